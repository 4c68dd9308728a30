// test_kinematics.cpp: the seven poses of CONVENTIONS.md, and that angles between directions survive the turns.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "kinematics.hpp"

namespace gonio::sim {
namespace {

constexpr double deg = std::numbers::pi / 180.0;

struct Pose {
    std::array<double, axis_count> q_deg;
    double incident_theta, incident_phi;
    double outgoing_theta, outgoing_phi;
};

double theta_deg(const Vec3 &v) {
    return std::atan2(std::hypot(v[0], v[1]), v[2]) / deg;
}

double turn_deg(const Vec3 &v, double phi_deg) {
    return std::remainder(std::atan2(v[1], v[0]) / deg - phi_deg, 360.0);
}

Instrument reference() {
    return load_instrument(GONIO_SOURCE_DIR "/protocol/axes.toml");
}

} // namespace

TEST(Kinematics, SevenPoses) {
    Kinematics const kinematics(reference().axes);
    for (const Pose &pose : {
             Pose{{0, 0, 30, 0}, 0, 0, 30, 0},
             Pose{{30, 0, 0, 0}, 30, 0, 30, 0},
             Pose{{30, 0, -60, 0}, 30, 0, 30, 180},
             Pose{{30, 0, 180, 0}, 30, 0, 150, 180},
             Pose{{30, 90, 0, 45}, 30, 90, 52.2388, 153.4349},
             Pose{{60, 210, -75, 20}, 60, 210, 24.8142, 335.4166},
             Pose{{150, 0, 20, -10}, 150, 0, 165.8940, 314.5615},
         }) {
        Directions const d = kinematics.directions(pose.q_deg);
        EXPECT_NEAR(theta_deg(d.incident), pose.incident_theta, 1e-6);
        EXPECT_NEAR(theta_deg(d.outgoing), pose.outgoing_theta, 6e-5);
        if (pose.incident_theta > 0) {
            EXPECT_NEAR(turn_deg(d.incident, pose.incident_phi), 0.0, 6e-5);
        }
        EXPECT_NEAR(turn_deg(d.outgoing, pose.outgoing_phi), 0.0, 6e-5);
    }
}

// lab <- sample = R_Y(-q1) R_z(-q2): the lab's +Y lies in the sample's plane, turned by the roll.
TEST(Kinematics, TheLabsUpShowsTheRoll) {
    Kinematics const kinematics(reference().axes);
    for (double const q2 : {0.0, 30.0, 210.0}) {
        Vec3 const up = kinematics.directions({40.0, q2, 5.0, 6.0}).lab_up;
        EXPECT_NEAR(up[0], -std::sin(q2 * deg), 1e-12);
        EXPECT_NEAR(up[1], std::cos(q2 * deg), 1e-12);
        EXPECT_NEAR(up[2], 0.0, 1e-12);
    }
}

// The sample's turns do not change the angle between source and detector: cos q3 cos q4.
TEST(Kinematics, AngleBetweenSourceAndDetectorIsTheArms) {
    Kinematics const kinematics(reference().axes);
    for (double q1 = -5; q1 < 185; q1 += 23) {
        for (double q3 = -190; q3 < 200; q3 += 37) {
            Directions const d = kinematics.directions({q1, 2 * q1, q3, q3 / 3});
            double const dot =
                d.incident[0] * d.outgoing[0] + d.incident[1] * d.outgoing[1] + d.incident[2] * d.outgoing[2];
            EXPECT_NEAR(dot, std::cos(q3 * deg) * std::cos(q3 / 3 * deg), 1e-12);
        }
    }
}

} // namespace gonio::sim
