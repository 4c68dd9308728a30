// test_closed_form.cpp: the convolved closed forms against brute-force quadrature, and their integrals against 1.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "closed_form.hpp"

namespace gonio::sim {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double deg = pi / 180.0;

Vec3 direction(double theta_deg, double phi_deg) {
    double const s = std::sin(theta_deg * deg);
    return {s * std::cos(phi_deg * deg), s * std::sin(phi_deg * deg), std::cos(theta_deg * deg)};
}

struct Instrument {
    Beam_profile beam;
    double aperture_rad;
};

// Average of f over the aperture's disc and the beam's profile by the midpoint rule on both, four nested sums with no
// symmetry used: each direction of the beam shifts the lobe's axis, each point of the aperture the place of the
// reading.
double brute_force(const Zonal &f, const Instrument &instrument, double gamma, int n) {
    int const beam_radii = 15 * n;
    int const sectors = 20; // periodic, so a few are exact
    double const reach = 0.5 * (instrument.beam.full_width_rad + instrument.beam.edge_rad);
    double sum = 0.0;
    double weight = 0.0;
    for (int i = 0; i < beam_radii; ++i) {
        double const beta = reach * (i + 0.5) / beam_radii;
        double const beam = instrument.beam.at(beta) * std::sin(beta);
        for (int j = 0; j < sectors; ++j) {
            double const psi = 2.0 * pi * (j + 0.5) / sectors;
            Vec3 const axis = {std::sin(beta) * std::cos(psi), std::sin(beta) * std::sin(psi), std::cos(beta)};
            for (int k = 0; k < n; ++k) {
                double const alpha = instrument.aperture_rad * (k + 0.5) / n;
                for (int l = 0; l < sectors; ++l) {
                    double const chi = 2.0 * pi * (l + 0.5) / sectors;
                    // The aperture's point, turned by gamma about y.
                    double const x = std::sin(alpha) * std::cos(chi);
                    double const y = std::sin(alpha) * std::sin(chi);
                    double const z = std::cos(alpha);
                    double const dot = axis[0] * (x * std::cos(gamma) + z * std::sin(gamma)) + axis[1] * y +
                                       axis[2] * (z * std::cos(gamma) - x * std::sin(gamma));
                    double const w = beam * std::sin(alpha);
                    sum += w * f(std::acos(std::clamp(dot, -1.0, 1.0)));
                    weight += w;
                }
            }
        }
    }
    return sum / weight;
}

// Richardson's extrapolation removes the midpoint rule's leading error.
double reference(const Zonal &f, const Instrument &instrument, double gamma) {
    double const coarse = brute_force(f, instrument, gamma, 8);
    double const fine = brute_force(f, instrument, gamma, 16);
    return fine + (fine - coarse) / 3.0;
}

double sphere_integral(const Optics &optics, const Vec3 &incident, bool mounted, double about_theta,
                       double radius_deg) {
    // In rings about a direction with phi = 180; the midpoint rule in theta and phi.
    int const rings = 1600;
    int const sectors = 180;
    double sum = 0.0;
    double const tilt = about_theta * deg;
    for (int i = 0; i < rings; ++i) {
        double const gamma = radius_deg * deg * (i + 0.5) / rings;
        for (int j = 0; j < sectors; ++j) {
            double const psi = 2.0 * pi * (j + 0.5) / sectors;
            double const x = std::sin(gamma) * std::cos(psi);
            double const z = std::cos(gamma);
            Vec3 const outgoing = {-(x * std::cos(tilt) + z * std::sin(tilt)), std::sin(gamma) * std::sin(psi),
                                   z * std::cos(tilt) - x * std::sin(tilt)};
            sum += optics.apparent_dsf_per_sr({incident, outgoing, mounted}) * std::sin(gamma);
        }
    }
    return sum * (radius_deg * deg / rings) * (2.0 * pi / sectors);
}

Instrument const focused{{1.0 * deg, 0.2 * deg}, std::atan(5.0 / 1020.0)};
Instrument const collimated{{2.0 * std::atan(32.5 / 1020.0), 0.3 * deg}, std::atan(5.0 / 1020.0)};

} // namespace

TEST(ClosedForm, LobeEqualsBruteForce) {
    for (const Instrument &instrument : {focused, collimated}) {
        for (double const sigma_deg : {0.5, 1.2, 8.0}) {
            double const sigma = sigma_deg * deg;
            double const peak = gaussian_peak_per_sr(sigma);
            Closed_form const optics({{}, {{Lobe_axis::mirror, sigma_deg, 1.0}}, {}}, instrument.beam,
                                     instrument.aperture_rad);
            for (double const offset : {0.0, 0.7, 1.9, 3.5}) {
                double const gamma = offset * sigma;
                double const expected = reference(
                    [&](double g) { return peak * std::exp(-0.5 * g * g / (sigma * sigma)); }, instrument, gamma);
                double const got =
                    optics.apparent_dsf_per_sr({direction(30.0, 0.0), direction(30.0 + gamma / deg, 180.0), true});
                EXPECT_NEAR(got / expected, 1.0, 1e-5) << "sigma " << sigma_deg << " at " << offset << " sigma";
            }
        }
    }
}

TEST(ClosedForm, LambertianNearTheHorizonEqualsBruteForce) {
    Closed_form const optics({{{0.5, 0.0}}, {}, {}}, collimated.beam, collimated.aperture_rad);
    // 2e-7 (0.16 at the normal) is what the midpoint sum resolves at the cosine's kink.
    for (double const theta : {0.0, 40.0, 87.5, 89.0, 89.9, 90.7}) {
        double const expected =
            reference([](double g) { return 0.5 / pi * std::max(0.0, std::cos(g)); }, collimated, theta * deg);
        double const got = optics.apparent_dsf_per_sr({direction(20.0, 0.0), direction(theta, 75.0), true});
        EXPECT_NEAR(got, expected, 1e-5 * expected + 2e-7) << theta;
    }
}

TEST(ClosedForm, FreeBeamHasUnitIntegral) {
    for (const Instrument &instrument : {focused, collimated}) {
        Closed_form const optics({}, instrument.beam, instrument.aperture_rad);
        EXPECT_NEAR(sphere_integral(optics, direction(0.0, 0.0), false, 180.0, 4.0), 1.0, 1e-5);
        Beam_kernel const kernel(instrument.beam, instrument.aperture_rad);
        EXPECT_NEAR(integrate_sphere_sr([&](double g) { return kernel.per_sr(g); }, kernel.breaks_rad()), 1.0, 1e-7);
    }
}

// Where the aperture lies wholly within the top hat the profile is 1 / (solid angle of the beam), whatever the
// aperture.
TEST(ClosedForm, FreeBeamsPlateauIsTheInverseSolidAngle) {
    Beam_profile const sharp{3.0 * deg, 0.0};
    Beam_kernel const kernel(sharp, 0.28 * deg);
    EXPECT_NEAR(kernel.per_sr(0.4 * deg) * 2.0 * pi * (1.0 - std::cos(1.5 * deg)), 1.0, 1e-7);
    EXPECT_EQ(kernel.per_sr(1.79 * deg), 0.0);
}

TEST(ClosedForm, IntegralsAreTheStatedReflectances) {
    Sample const sample{{{0.5, 0.2}}, {}, {}};
    Closed_form const optics(sample, focused.beam, focused.aperture_rad);
    for (double const theta : {0.0, 50.0, 150.0}) {
        EXPECT_NEAR(sphere_integral(optics, direction(theta, 0.0), true, 0.0, 180.0), 0.7, 2e-6);
        double const side = theta < 90.0 ? 0.0 : 180.0;
        EXPECT_NEAR(sphere_integral(optics, direction(theta, 0.0), true, side, 89.0),
                    0.5 * std::pow(std::sin(89.0 * deg), 2), 3e-5);
    }
}

TEST(ClosedForm, LobesStandInTheirDirections) {
    struct Case {
        Lobe_axis about;
        double theta;
        double phi;
    };
    for (const Case &c : {Case{Lobe_axis::mirror, 40.0, 250.0}, Case{Lobe_axis::retro, 40.0, 70.0},
                          Case{Lobe_axis::through, 140.0, 250.0}}) {
        Closed_form const optics({{}, {{c.about, 1.2, 0.2}}, {}}, focused.beam, focused.aperture_rad);
        Vec3 const incident = direction(40.0, 70.0);
        double const top = optics.apparent_dsf_per_sr({incident, direction(c.theta, c.phi), true});
        EXPECT_GT(top, 60.0);
        EXPECT_LT(optics.apparent_dsf_per_sr({incident, direction(c.theta + 0.1, c.phi), true}), top);
        EXPECT_LT(optics.apparent_dsf_per_sr({incident, direction(c.theta, c.phi - 0.2), true}), top);
        EXPECT_NEAR(
            sphere_integral(optics, direction(40.0, 0.0), true, c.about == Lobe_axis::retro ? -40.0 : c.theta, 15.0),
            0.2, 2e-5);
    }
}

// CONVENTIONS.md: a top hat of 0.56 / 1.0 / 1.5 / 3.0 degrees lowers a peak of sigma 1.2 degrees by 1.4 / 4.2 / 9.2 /
// 31 %; the beam alone, with a vanishing aperture.
TEST(ClosedForm, TopHatLowersThePeakAsTheConventionsSay) {
    struct Case {
        double width_deg;
        double lowered_percent;
        double rounding;
    };
    for (const Case &c : {Case{0.56, 1.4, 0.06}, Case{1.0, 4.2, 0.06}, Case{1.5, 9.2, 0.06}, Case{3.0, 31.0, 0.5}}) {
        Closed_form const optics({{}, {{Lobe_axis::mirror, 1.2, 1.0}}, {}}, {c.width_deg * deg, 0.0}, 1e-4);
        double const top = optics.apparent_dsf_per_sr({direction(0.0, 0.0), direction(0.0, 0.0), true});
        EXPECT_NEAR(100.0 * (1.0 - top / gaussian_peak_per_sr(1.2 * deg)), c.lowered_percent, c.rounding);
    }
}

} // namespace gonio::sim
