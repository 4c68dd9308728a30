// test_window_glass.cpp: panes: Fresnel, absorption, wedge, relief and bubbles.
#include <gtest/gtest.h>

#include <cmath>

#include "sample_walk.hpp"

using namespace gonio::sim;

namespace {

std::string pane(const std::string &keys, const std::string &glass = "") {
    return "[sample]\nkind = \"window-glass\"\nmaterial = \"glass\"\n" + keys +
           "\n[materials.glass]\nkind = \"dielectric\"\nindex = 1.5\n" + glass;
}

// Power reflected by one face, unpolarised.
double fresnel(double incident_rad) {
    double const inside = std::asin(std::sin(incident_rad) / 1.5);
    if (incident_rad == 0.0) {
        return 0.04;
    }
    double const s = std::sin(incident_rad - inside) / std::sin(incident_rad + inside);
    double const p = std::tan(incident_rad - inside) / std::tan(incident_rad + inside);
    return 0.5 * (s * s + p * p);
}

} // namespace

// All reflections between the faces; here light is unpolarised anew at each.
TEST(WindowGlass, SmoothPaneIsFresnels) {
    int const photons = 40000;
    Sample_walk const clear(pane("size_mm = 60.0"));
    for (double const theta_deg : {0.0, 50.0, 70.0}) {
        double const r = fresnel(theta_deg * deg);
        double const expected = (1.0 - r) / (1.0 + r);
        EXPECT_NEAR(sums(clear, theta_deg, 30.0, photons).transmitted, expected,
                    4.0 * std::sqrt(expected * (1.0 - expected) / photons))
            << theta_deg;
    }
    Sample_walk const tinted(pane("thickness_mm = 5.0", "absorption_per_mm = 0.1"));
    double const a = std::exp(-0.5);
    Sums const got = sums(tinted, 0.0, 0.0, photons);
    EXPECT_NEAR(got.transmitted, 0.96 * 0.96 * a / (1.0 - 0.04 * 0.04 * a * a), 4.0 * 0.2 / std::sqrt(photons));
    EXPECT_NEAR(got.reflected, 0.04 + 0.96 * 0.96 * 0.04 * a * a / (1.0 - 0.04 * 0.04 * a * a),
                4.0 * 0.2 / std::sqrt(photons));
}

// asin(n sin wedge) - wedge, towards the thick side; 0.5 degrees to first order for 1 degree.
TEST(WindowGlass, WedgeTurnsTheLight) {
    Sample_walk const walk(pane("wedge_deg = 1.0"));
    double const turned_deg = std::asin(1.5 * std::sin(1.0 * deg)) / deg - 1.0;
    EXPECT_NEAR(turned_deg, 0.5, 2e-3);
    int direct = 0;
    shine(walk, towards(0.0, 0.0), 1000, [&](const Light &light) {
        if (light.interactions == 2 && light.direction.z < 0.0) {
            EXPECT_NEAR(std::asin(light.direction.y) / deg, turned_deg, 1e-9);
            EXPECT_NEAR(light.direction.x, 0.0, 1e-12);
            ++direct;
        }
    });
    EXPECT_GT(direct, 850);
}

// Heights of the relief have the stated standard deviation and slopes sqrt(2) rms / length: means over 30 x 30
// lengths, about 900 independent patches, so 5 % is more than four of their standard errors.
TEST(WindowGlass, ReliefIsAsStated) {
    Sample_walk const walk(pane("size_mm = 66.0\nfront_rms_um = 30.0\nfront_correlation_mm = 2.0"));
    double heights = 0.0;
    double squares = 0.0;
    double slopes = 0.0;
    int const side = 250;
    for (int i = 0; i < side * side; ++i) {
        Hit hit{};
        double const x = 60.0 * ((i % side + 0.5) / side - 0.5);
        double const y = 60.0 * ((i / side + 0.5) / side - 0.5);
        ASSERT_TRUE(walk.scene().closest({{x, y, 1.0}, {0.0, 0.0, -1.0}}, hit));
        heights += 1.0 - hit.distance_mm;
        squares += (1.0 - hit.distance_mm) * (1.0 - hit.distance_mm);
        slopes += (hit.normal.x * hit.normal.x) / (hit.normal.z * hit.normal.z);
    }
    double const count = side * side;
    EXPECT_NEAR(heights / count, 0.0, 4.0 * 0.03 / 20.0);
    EXPECT_NEAR(std::sqrt(squares / count), 0.03, 0.05 * 0.03 * 1.5);
    EXPECT_NEAR(std::sqrt(slopes / count), std::sqrt(2.0) * 0.03 / 2.0, 0.05 * std::sqrt(2.0) * 0.03 / 2.0);
}

// Nothing is lost but at the rims, which are far: bubbles and relief spread light without taking any.
TEST(WindowGlass, BubblesAndReliefTakeNothing) {
    Sample_walk const walk(pane("size_mm = 40.0\nfront_rms_um = 20.0\nback_rms_um = 10.0\nbubbles_per_cm3 = 500.0\n"
                                "bubble_diameter_mm = [0.1, 0.4]"));
    // 4.8 cm3 of glass; rims, faces and overlaps cost some.
    EXPECT_GT(walk.sample().shapes.spheres().size(), 1500U);
    EXPECT_LE(walk.sample().shapes.spheres().size(), 2400U);
    int const photons = 6000;
    Sums const got = sums(walk, 20.0, 60.0, photons);
    // Trapped light, sent beyond the angle of total reflection by bubbles (which cover 6 % of the pane), ends in the
    // rims.
    EXPECT_GT(got.transmitted + got.reflected, 0.95);
    EXPECT_LE(got.transmitted + got.reflected, 1.0);
}

// The limit of a small bubble: light through its middle goes straight on.
TEST(WindowGlass, BubbleIsAirInGlass) {
    Sample_walk const walk(pane("bubbles_per_cm3 = 5.0\nbubble_diameter_mm = 0.5\nrelief_seed = 3"));
    Hit hit{};
    bool found = false;
    // Rays along z that miss the middle of a bubble by b are turned away from the axis, by 2 (r - i), sin r = n sin i.
    for (int i = 0; i < 90000 && !found; ++i) {
        Ray const ray{{0.1 * (i % 300) - 15.0, 0.1 * (i / 300) - 15.0, 1.0}, {0.0, 0.0, -1.0}};
        if (!walk.scene().closest(ray, hit)) {
            continue;
        }
        Ray const within{ray.origin + hit.distance_mm * ray.direction, ray.direction, hit.primitive};
        Hit bubble{};
        if (!walk.scene().closest(within, bubble) || bubble.normal.z > 0.9999 || bubble.normal.z < 0.75) {
            continue;
        }
        found = true;
        double const incident = std::acos(bubble.normal.z);
        double const turned = 2.0 * (std::asin(1.5 * std::sin(incident)) - incident);
        // Of many photons along this ray the most go straight through: face, in, out, face.
        for (std::uint64_t photon = 0; photon < 50; ++photon) {
            Photon_random random(9, photon);
            Light const light = walk.follow(ray, random);
            if (light.interactions == 4 && light.direction.z < 0.0) {
                double const outside = std::asin(1.5 * std::sin(turned));
                EXPECT_NEAR(std::acos(-light.direction.z), outside, 1e-9);
                // Away from the axis: an air bubble is a weak diverging lens.
                EXPECT_GT(light.direction.x * bubble.normal.x + light.direction.y * bubble.normal.y, 0.0);
            }
        }
    }
    EXPECT_TRUE(found);
}

TEST(WindowGlass, BubblesThatDoNotFitOrAreTooManyAreRefused) {
    EXPECT_THROW(Sample_walk(pane("bubbles_per_cm3 = 1e9")), Input_error);
    EXPECT_THROW(Sample_walk(pane("bubbles_per_cm3 = 1.0\nbubble_diameter_mm = [5.0, 6.0]")), Input_error);
    EXPECT_NO_THROW(Sample_walk(pane("bubbles_per_cm3 = 1.0\nbubble_diameter_mm = [0.1, 6.0]")));
}
