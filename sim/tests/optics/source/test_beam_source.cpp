// test_beam_source.cpp: where photons start and which way they go, against the profiles that were asked for.
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "beam_source.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr int photons = 100000;

std::vector<Start> draw(const Source_settings &settings, int count = photons) {
    Beam_source const source(settings);
    std::vector<Start> starts;
    for (int n = 0; n < count; ++n) {
        Photon_random random(11, static_cast<std::uint64_t>(n));
        starts.push_back(source.start(random));
    }
    return starts;
}

double angle_deg(const Start &start) {
    return std::atan2(std::hypot(start.direction.x, start.direction.y), -start.direction.z) / deg;
}

// Chi-square of values in [0, most) against a density (not normalised), in equal bins; fails four standard deviations
// above its mean. Values outside fail.
void expect_density(const std::vector<double> &values, double most, const std::function<double(double)> &density) {
    constexpr int bins = 40;
    constexpr int steps = 200;
    std::vector<double> expected(bins);
    double sum = 0.0;
    for (int i = 0; i < bins * steps; ++i) {
        double const d = density(most * (i + 0.5) / (bins * steps));
        expected[static_cast<std::size_t>(i / steps)] += d;
        sum += d;
    }
    std::vector<double> counts(bins);
    for (double const value : values) {
        ASSERT_GE(value, 0.0);
        ASSERT_LT(value, most);
        ++counts[static_cast<std::size_t>(value / most * bins)];
    }
    double chi_square = 0.0;
    int freedom = -1;
    for (std::size_t i = 0; i < bins; ++i) {
        double const mean = expected[i] / sum * static_cast<double>(values.size());
        if (mean > 5.0) {
            chi_square += (counts[i] - mean) * (counts[i] - mean) / mean;
            ++freedom;
        } else {
            ASSERT_LE(counts[i], 25.0);
        }
    }
    EXPECT_LT(chi_square, freedom + 4.0 * std::sqrt(2.0 * freedom));
}

// Transition of the raised cosine from 1 to 0 about `radius`, `edge` wide.
double soft_edge(double r, double radius, double edge) {
    double const x = (r - radius) / edge;
    return x < -0.5 ? 1.0 : x > 0.5 ? 0.0 : 0.5 * (1.0 - std::sin(std::numbers::pi * x));
}

TEST(Beam_source, collimated_beam_fills_the_stop_and_its_opening_angle) {
    std::vector<double> radii;
    std::vector<double> angles;
    double x = 0.0;
    double y = 0.0;
    for (Start const &start : draw({.diameter_mm = 60.0, .stop_distance_mm = 800.0, .opening_angle_deg = 4.0})) {
        EXPECT_EQ(start.position.z, 800.0);
        EXPECT_NEAR(length(start.direction), 1.0, 1e-14);
        radii.push_back(std::hypot(start.position.x, start.position.y));
        angles.push_back(angle_deg(start));
        x += start.position.x * start.direction.x;
        y += start.position.y * start.direction.y;
    }
    expect_density(radii, 30.0 + 1e-9, [](double r) { return r; });
    expect_density(angles, 2.0 + 1e-9, [](double a) { return std::sin(a * deg); });
    // Places and directions know nothing of each other: standard deviations of a disc's coordinate are half its radius.
    double const sigma = 15.0 * std::sin(1.0 * deg) * std::sqrt(photons);
    EXPECT_LT(std::abs(x), 4.0 * sigma);
    EXPECT_LT(std::abs(y), 4.0 * sigma);
}

TEST(Beam_source, azimuths_are_uniform) {
    std::vector<double> places;
    std::vector<double> directions;
    for (Start const &start : draw({})) {
        places.push_back(std::atan2(start.position.y, start.position.x) + std::numbers::pi);
        directions.push_back(std::atan2(start.direction.y, start.direction.x) + std::numbers::pi);
    }
    expect_density(places, 2.0 * std::numbers::pi + 1e-9, [](double) { return 1.0; });
    expect_density(directions, 2.0 * std::numbers::pi + 1e-9, [](double) { return 1.0; });
}

TEST(Beam_source, edges_are_raised_cosines) {
    std::vector<double> radii;
    std::vector<double> angles;
    for (Start const &start :
         draw({.diameter_mm = 20.0, .diameter_edge_mm = 8.0, .opening_angle_deg = 3.0, .edge_deg = 2.0})) {
        radii.push_back(std::hypot(start.position.x, start.position.y));
        angles.push_back(angle_deg(start));
    }
    expect_density(radii, 14.0, [](double r) { return r * soft_edge(r, 10.0, 8.0); });
    expect_density(angles, 2.5, [](double a) { return std::sin(a * deg) * soft_edge(a, 1.5, 2.0); });
}

TEST(Beam_source, focused_beam_converges_from_the_stop_to_the_spot) {
    std::vector<double> spot;
    std::vector<double> angles;
    double widest = 0.0;
    for (Start const &start :
         draw({.kind = Beam_kind::focused, .diameter_mm = 8.0, .stop_distance_mm = 1000.0, .opening_angle_deg = 6.0})) {
        EXPECT_EQ(start.position.z, 1000.0);
        Vector const on_sample = start.position - (start.position.z / start.direction.z) * start.direction;
        EXPECT_NEAR(on_sample.z, 0.0, 1e-9);
        spot.push_back(std::hypot(on_sample.x, on_sample.y));
        angles.push_back(angle_deg(start));
        widest = std::max(widest, std::hypot(start.position.x, start.position.y));
    }
    expect_density(spot, 4.0 + 1e-9, [](double r) { return r; });
    expect_density(angles, 3.0 + 1e-9, [](double a) { return std::sin(a * deg); });
    // At the stop the cone is as wide as the spot's radius and 1000 mm tan(3 deg) together.
    EXPECT_NEAR(widest, 4.0 + 1000.0 * std::tan(3.0 * deg), 1.0);
}

TEST(Beam_source, lamp_at_a_finite_distance_diverges_across_the_stop) {
    constexpr double lamp_mm = 500.0;
    for (Start const &start :
         draw({.diameter_mm = 40.0, .opening_angle_deg = 0.0, .lamp_distance_mm = lamp_mm}, 1000)) {
        // Back to the lamp: a point on the axis.
        Vector const lamp = start.position + (lamp_mm / start.direction.z) * start.direction;
        EXPECT_NEAR(lamp.x, 0.0, 1e-10);
        EXPECT_NEAR(lamp.y, 0.0, 1e-10);
    }
    // A lamp that is seen under 2 degrees has a radius of 500 mm tan(1 deg), wherever on the stop one looks from.
    std::vector<double> radii;
    for (Start const &start : draw({.opening_angle_deg = 2.0, .lamp_distance_mm = lamp_mm})) {
        Vector const lamp = start.position + (lamp_mm / start.direction.z) * start.direction;
        radii.push_back(std::hypot(lamp.x, lamp.y));
    }
    expect_density(radii, lamp_mm * std::tan(1.0 * deg) + 1e-9, [](double r) { return r; });
}

TEST(Beam_source, radial_profile_is_drawn_by_solid_angle) {
    std::vector<double> angles;
    for (Start const &start :
         draw({.radial = {{0.0, 1.0}, {1.0, 0.2}, {2.0, 0.0}, {3.0, 0.0}, {4.0, 0.5}, {5.0, 0.0}}})) {
        angles.push_back(angle_deg(start));
    }
    expect_density(angles, 5.0, [](double a) {
        double const power = a < 1.0   ? 1.0 - 0.8 * a
                             : a < 2.0 ? 0.4 - 0.2 * a
                             : a < 3.0 ? 0.0
                             : a < 4.0 ? 0.5 * (a - 3.0)
                                       : 0.5 * (5.0 - a);
        return power * std::sin(a * deg);
    });
}

TEST(Beam_source, filament_bars_have_their_places_widths_and_powers) {
    auto const starts =
        draw({.filament = {
                  {.x_deg = -1.0, .width_deg = 0.4, .height_deg = 1.6, .weight = 3.0},
                  {.x_deg = 5.0, .weight = 0.0},
                  {.x_deg = 2.0, .y_deg = 0.5, .width_deg = 0.2, .height_deg = 0.3, .weight = 1.0, .gaussian = true}}});
    std::vector<double> x;
    std::vector<double> y;
    double gaussian = 0.0;
    double sum_x = 0.0;
    double square_x = 0.0;
    double square_y = 0.0;
    for (Start const &start : starts) {
        // Where it is seen: against the direction of travel.
        double const seen_x = start.direction.x / start.direction.z;
        double const seen_y = start.direction.y / start.direction.z;
        if (seen_x < 0.0) {
            x.push_back(seen_x + std::tan(1.0 * deg) + std::tan(0.2 * deg));
            y.push_back(seen_y + std::tan(0.8 * deg));
        } else {
            gaussian += 1.0;
            sum_x += seen_x - std::tan(2.0 * deg);
            square_x += std::pow(seen_x - std::tan(2.0 * deg), 2);
            square_y += std::pow(seen_y - std::tan(0.5 * deg), 2);
        }
    }
    EXPECT_NEAR(gaussian, 0.25 * photons, 4.0 * std::sqrt(0.1875 * photons));
    expect_density(x, 2.0 * std::tan(0.2 * deg) + 1e-12, [](double) { return 1.0; });
    expect_density(y, 2.0 * std::tan(0.8 * deg) + 1e-12, [](double) { return 1.0; });
    // Full widths at half maximum over standard deviation: 2.3548.
    double const sigma_x = 0.2 * deg / 2.3548;
    double const sigma_y = 0.3 * deg / 2.3548;
    EXPECT_NEAR(sum_x / gaussian, 0.0, 4.0 * sigma_x / std::sqrt(gaussian));
    double const relative = 4.0 * std::sqrt(0.5 / gaussian); // of a standard deviation
    EXPECT_NEAR(std::sqrt(square_x / gaussian) / sigma_x, 1.0, relative);
    EXPECT_NEAR(std::sqrt(square_y / gaussian) / sigma_y, 1.0, relative);
}

TEST(Beam_source, stray_light_has_its_share_and_its_cone) {
    std::vector<double> stray;
    std::vector<double> radii;
    for (Start const &start : draw({.diameter_mm = 60.0, .stray_share = 0.2, .stray_half_angle_deg = 20.0})) {
        radii.push_back(std::hypot(start.position.x, start.position.y));
        if (angle_deg(start) > 0.25) {
            stray.push_back(angle_deg(start));
        }
    }
    // Of the stray light (0.25 / 20)^2 hides in the beam.
    double const expected = 0.2 * (1.0 - 1.6e-4);
    EXPECT_NEAR(static_cast<double>(stray.size()), expected * photons, 4.0 * std::sqrt(expected * 0.8 * photons));
    expect_density(stray, 20.0 + 1e-9, [](double a) { return std::sin(a * deg); });
    expect_density(radii, 30.0 + 1e-9, [](double r) { return r; });
}

TEST(Beam_source, stray_light_of_a_focused_beam_leaves_the_stop_where_the_beam_does) {
    for (Start const &start : draw({.kind = Beam_kind::focused,
                              .diameter_mm = 8.0,
                              .stop_distance_mm = 1000.0,
                              .opening_angle_deg = 1.0,
                              .stray_share = 0.5,
                              .stray_half_angle_deg = 30.0},
                                   2000)) {
        EXPECT_LE(std::hypot(start.position.x, start.position.y), 4.0 + 1000.0 * std::tan(0.5 * deg) + 1e-9);
    }
}

// Two numbers for the place, two for the direction: a low-discrepancy point's first four dimensions.
TEST(Beam_source, order_of_the_random_numbers) {
    Beam_source const source({.diameter_mm = 20.0, .opening_angle_deg = 2.0});
    Photon_random random(1, 1);
    random.give({0x40000000U, 0x40000000U, 0xFFFFFFFFU, 0x80000000U, 0x12345678U}, 5);
    Start const start = source.start(random);
    EXPECT_NEAR(start.position.x, 0.0, 1e-6);
    EXPECT_NEAR(start.position.y, 5.0, 1e-6); // a quarter of the area, a quarter of a turn
    EXPECT_NEAR(angle_deg(start), 1.0, 1e-6);
    EXPECT_GT(start.direction.x, 0.0); // seen at half a turn, on the left
    EXPECT_EQ(random.uniform(), (0x12345678 + 0.5) * 0x1p-32);
}

TEST(Beam_source, polarisation_refers_to_the_labs_y) {
    EXPECT_EQ(linear_polarisation(0.0).q, 1.0);
    EXPECT_NEAR(linear_polarisation(90.0).q, -1.0, 1e-15);
    EXPECT_NEAR(linear_polarisation(45.0).u, 1.0, 1e-15);
    for (Start const &start :
         draw({.opening_angle_deg = 20.0, .stray_share = 0.5, .stokes = linear_polarisation(30.0)}, 1000)) {
        EXPECT_NEAR(length(start.reference), 1.0, 1e-14);
        EXPECT_NEAR(dot(start.reference, start.direction), 0.0, 1e-14);
        // In the plane of Y and the direction, on Y's side.
        EXPECT_NEAR(dot(start.reference, cross(start.direction, {0.0, 1.0, 0.0})), 0.0, 1e-14);
        EXPECT_GT(start.reference.y, 0.9);
        EXPECT_NEAR(start.stokes.q, 0.5, 1e-15);
        EXPECT_NEAR(start.stokes.u, std::sqrt(0.75), 1e-15);
    }
}

TEST(Beam_source, refuses_what_is_no_beam) {
    auto const refused = [](const Source_settings &settings, const std::string &word) {
        try {
            Beam_source const source(settings);
            ADD_FAILURE() << "accepted: " << word;
        } catch (const Input_error &error) {
            EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
        }
    };
    refused({.diameter_mm = 0.0}, "diameter_mm");
    refused({.diameter_mm = 5.0, .diameter_edge_mm = 6.0}, "edge");
    refused({.stop_distance_mm = std::nan("")}, "stop");
    refused({.opening_angle_deg = 100.0}, "opening angle");
    refused({.opening_angle_deg = 0.5, .edge_deg = 1.0}, "edge_deg");
    refused({.radial = {{1.0, 1.0}, {2.0, 0.0}}}, "first at 0");
    refused({.radial = {{0.0, 1.0}, {0.0, 0.0}}}, "ascend");
    refused({.radial = {{0.0, 0.0}, {1.0, 0.0}}}, "zero everywhere");
    refused({.filament = {{.weight = -1.0}}}, "weight");
    refused({.filament = {{.weight = 0.0}}}, "weights");
    refused({.filament = {{.width_deg = -0.1}}}, "width");
    refused({.kind = Beam_kind::focused, .lamp_distance_mm = 100.0}, "lamp distance");
    refused({.stray_share = 1.0}, "stray share");
    refused({.stray_share = 0.1, .stray_half_angle_deg = 90.0}, "half angle");
    refused({.stokes = {1.0, 1.0, 0.0}}, "Stokes");
}

} // namespace
} // namespace gonio::sim
