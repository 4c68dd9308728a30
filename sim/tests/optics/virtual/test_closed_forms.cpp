// test_closed_forms.cpp: scenario to reading, against answers from physics: no loss and no gain, a Lambertian disc of
// finite size, a mirror image narrower and wider than the aperture, the tilt of a louver from its shadow.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "written_scenario.hpp"

namespace gonio::sim::test {
namespace {

constexpr double rad_per_deg = std::numbers::pi / 180.0;

// A share of n photons, and 4 standard errors of it.
struct Share {
    double value;
    double tolerance;
};
Share share(std::uint64_t weight, std::uint64_t photons) {
    double const value = static_cast<double>(weight) * weight_unit / static_cast<double>(photons);
    return {value, 4.0 * std::sqrt(value * (1.0 - value) / static_cast<double>(photons))};
}

void expect_no_loss(const std::string &text, double theta_deg, double phi_deg) {
    constexpr std::uint64_t photons = 20000;
    Photon_scenario const scenario = written_scenario(text);
    std::array const poles = {Vector{0, 0, 1}, Vector{0, 0, -1}};
    for (Walk const walk : {Walk::automatic, Walk::embree}) {
        Watch watch;
        auto const [sums, balance] =
            at(scenario, theta_deg, phi_deg, walk).read(poles, 0.5 * std::numbers::pi, {0, photons}, 2, watch);
        EXPECT_EQ(balance.photons, photons);
        EXPECT_EQ(balance.stored, balance.emitted);
        EXPECT_EQ(balance.absorbed, 0);
        EXPECT_EQ(balance.lost, 0);
        // The two hemispheres hold them all; the rim between them belongs to both.
        EXPECT_NEAR(static_cast<double>(sums.weight[0] + sums.weight[1]), static_cast<double>(balance.stored),
                    2e-4 * static_cast<double>(balance.stored));
    }
}

TEST(Whole_chain, a_white_louver_returns_all_light) {
    std::string const white = "kind = \"lambertian\"\nreflectance = 1.0";
    expect_no_loss(louver("kind = \"mirror\"\nreflectance = 1.0", white), 45.0, 90.0);
    expect_no_loss(louver(white, white, "tilt_deg = 4.0"), 60.0, 75.0);
}

TEST(Whole_chain, clear_and_white_sheets_return_all_light) {
    std::string const sheet = "[sample]\nkind = \"sheet\"\nmaterial = \"m\"\n[materials.m]\n";
    expect_no_loss(sheet + "kind = \"lambertian\"\nreflectance = 0.25\ntransmittance = 0.75", 30.0, 10.0);
    expect_no_loss(sheet + "kind = \"thin-plate\"\nindex = 1.5", 75.0, 0.0);
}

// All light that a Lambertian disc sends through a cap about the normal passes the cap's rim: a disc seen from a
// parallel, coaxial disc (Howell, Menguc, Siegel, Thermal Radiation Heat Transfer, configuration C-41).
TEST(Whole_chain, a_lambertian_disc_of_finite_size_reads_as_the_view_factor_says) {
    constexpr std::uint64_t photons = 400000;
    constexpr double reflectance = 0.8;
    Photon_scenario const scenario =
        written_scenario("[sample]\nkind = \"lambertian\"\nreflectance = 0.8\nsize_mm = 800.0\n"
                         "[beam]\ndiameter_mm = 500.0\nedge_deg = 0.0\n[source]\nopening_angle_deg = 0.01\n");
    std::array const pole = {Vector{0, 0, 1}};
    for (double const half_angle_deg : {8.0, 20.0, 45.0}) {
        double const half_angle = half_angle_deg * rad_per_deg;
        Watch watch;
        auto const [sums, balance] = at(scenario, 0.0, 0.0).read(pole, half_angle, {0, photons}, 2, watch);
        double const disc = 250.0 / (scenario.receiver.radius_mm * std::cos(half_angle));
        double const rim = std::tan(half_angle);
        double const s = 1.0 + (1.0 + rim * rim) / (disc * disc);
        double const view_factor = 0.5 * (s - std::sqrt(s * s - 4.0 * (rim / disc) * (rim / disc)));
        Share const found = share(sums.weight[0], photons);
        EXPECT_NEAR(found.value, reflectance * view_factor, found.tolerance) << half_angle_deg;
        // A disc without size would send sin^2: the difference is there to be seen at the narrow cap.
        if (half_angle_deg < 10.0) {
            double const point = reflectance * std::sin(half_angle) * std::sin(half_angle);
            EXPECT_GT(std::abs(found.value - point), found.tolerance);
        }
    }
}

// What a detector reads in a mirror's image is the beam's cone convolved with the aperture: reflectance over the
// larger.
TEST(Whole_chain, a_mirror_image_reads_as_its_convolution_with_the_aperture) {
    constexpr std::uint64_t photons = 100000;
    Photon_scenario const scenario = written_scenario("[sample]\nkind = \"mirror\"\nreflectance = 0.9\n"
                                                      "[beam]\ndiameter_mm = 0.1\nedge_deg = 0.0\n"
                                                      "[source]\nopening_angle_deg = 2.0\nstop_distance_mm = 1.0\n");
    std::array const image = {direction(35.0, 200.0)};
    Virtual_goniophotometer const twin = at(scenario, 35.0, 20.0);
    for (double const half_angle_deg : {0.5, 3.0}) {
        double const half_angle = half_angle_deg * rad_per_deg;
        Watch watch;
        auto const [sums, balance] = twin.read(image, half_angle, {0, photons}, 2, watch);
        Estimate const found = estimate(sums.weight[0], sums.square[0], sums.hits[0], photons, half_angle);
        double const expected = 0.9 / cap_sr(std::max(half_angle, 1.0 * rad_per_deg));
        EXPECT_NEAR(found.dsf_per_sr, expected, 4.0 * found.standard_error_per_sr + weight_unit * expected);
    }
}

// Paper [1], figure 9: production slats were tilted by 4 degrees, found from the altitude at which no direct light
// passes.
TEST(Whole_chain, the_tilt_of_a_louver_follows_from_its_shadow) {
    constexpr std::uint64_t photons = 100000;
    std::string const black = "kind = \"black\"";
    for (double const tilt_deg : {0.0, -4.0}) {
        Photon_scenario const scenario =
            written_scenario(louver(black, black, "tilt_deg = " + std::to_string(tilt_deg)) +
                             "[beam]\ndiameter_mm = 130.0\nedge_deg = 0.0\n[source]\nopening_angle_deg = 0.01\n");
        constexpr double theta = 25.0 * rad_per_deg;
        std::array const through = {direction(155.0, 270.0)};
        Watch watch;
        auto const [sums, balance] = at(scenario, 25.0, 90.0).read(through, 0.2, {0, photons}, 2, watch);
        Share const passed = share(sums.weight[0], photons);
        // passed = 1 - (chord / pitch) sin(theta + inclination) / cos(theta); the sections sag within the shadow.
        double const sine = (1.0 - passed.value) * std::cos(theta) / 1.2;
        double const found_deg = (std::asin(sine) - theta) / rad_per_deg - 7.0;
        // The beam's 13 periods do not end on a slat: 2 J1(x) / x of it, x = 41, is 0.6 %.
        double const tolerance = (passed.tolerance + 0.006) * std::cos(theta) / 1.2 / std::sqrt(1.0 - sine * sine);
        EXPECT_NEAR(found_deg, tilt_deg, tolerance / rad_per_deg);
        EXPECT_LT(tolerance / rad_per_deg, 1.0);
    }
}

} // namespace
} // namespace gonio::sim::test
