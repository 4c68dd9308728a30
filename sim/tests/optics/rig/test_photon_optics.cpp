// test_photon_optics.cpp: which stored map answers a reading, and when one is traced: with maps made by hand.
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "photon_optics.hpp"

namespace gonio::sim {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr double half_angle_rad = 0.5 * deg;

struct Asked {
    Incident incident;
    bool mounted;
};

Vector direction(double theta_deg, double phi_deg) {
    double const theta = theta_deg * deg;
    double const phi = phi_deg * deg;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

// `count` photons of 100 arrive, all at one place.
Hit_map map_at(const Vector &place, std::size_t count) {
    Hit_store store(std::numbers::pi, 1);
    std::vector<Receiver_hit> const hits(count, {place, place, whole_weight(1.0)});
    store.take(hits, 0);
    return {store.release(), 100};
}

Vec3 components(const Vector &v) {
    return {v.x, v.y, v.z};
}

// As the axes of CONVENTIONS.md show it.
Reading reading_at(double q1_deg, double q2_deg, const Vector &outgoing, bool mounted = true) {
    return {components(direction(q1_deg, q2_deg)),
            components(outgoing),
            mounted,
            {-std::sin(q2_deg * deg), std::cos(q2_deg * deg), 0.0},
            false};
}

// One photon more in each map than in the one before, all of them at the sample's front normal.
class Bench {
public:
    explicit Bench(double tolerance_deg = 0.02, std::size_t memory_bytes = std::size_t{1} << 30U)
        : optics([this](const Incident &incident, bool mounted) { return trace(incident, mounted); },
                 {half_angle_rad, tolerance_deg, memory_bytes}) {}

    Hit_map trace(const Incident &incident, bool mounted) {
        asked.push_back({incident, mounted});
        return map_at({0.0, 0.0, 1.0}, asked.size());
    }
    // The number of the map that answers, from 1; 0: dark.
    [[nodiscard]] long answering(Reading reading, bool turning = false) const {
        reading.sample_turning = turning;
        return std::lround(optics.apparent_dsf_per_sr(reading) * cap_sr(half_angle_rad) * 100.0);
    }
    [[nodiscard]] long answering(double q1_deg, double q2_deg, bool turning = false) const {
        return answering(reading_at(q1_deg, q2_deg, {0.0, 0.0, 1.0}), turning);
    }

    std::vector<Asked> asked;
    Photon_optics optics;
};

} // namespace

TEST(Photon_optics, OneMapForEachIncidentDirection) {
    Bench bench;
    EXPECT_EQ(bench.answering(45.0009, 0.0), 1);
    EXPECT_EQ(bench.answering(44.9994, 0.0004), 1);
    EXPECT_EQ(bench.answering(30.0, 0.0), 2);
    EXPECT_EQ(bench.answering(45.0, 0.0), 1);
    EXPECT_EQ(bench.answering(45.0, 90.0), 3);
    EXPECT_EQ(bench.answering(45.05, 0.0), 4);
    ASSERT_EQ(bench.asked.size(), 4U);
    EXPECT_EQ(bench.asked[0].incident.theta_deg, 45.0) << "an encoder's count off is not what was meant";
    EXPECT_EQ(bench.asked[0].incident.phi_deg, 0.0);
    EXPECT_EQ(bench.asked[3].incident.theta_deg, 45.05);
    EXPECT_TRUE(bench.asked[0].mounted);
}

// A pose that lies between two steps of rounding does not flicker between two maps.
TEST(Photon_optics, ToleranceIsAboutTheTracedDirection) {
    Bench bench;
    for (int i = 0; i < 10; ++i) {
        EXPECT_EQ(bench.answering(45.005 + (i % 2 == 0 ? 1e-3 : -1e-3), 0.0), 1);
    }
}

TEST(Photon_optics, ASampleThatTurnsIsNotTraced) {
    Bench bench;
    EXPECT_EQ(bench.answering(10.0, 0.0, true), 0) << "dark: nothing is known yet";
    EXPECT_EQ(bench.answering(10.0, 0.0), 1);
    EXPECT_EQ(bench.answering(20.0, 0.0), 2);
    EXPECT_EQ(bench.answering(14.0, 0.0, true), 1);
    EXPECT_EQ(bench.answering(16.0, 0.0, true), 2);
    EXPECT_EQ(bench.asked.size(), 2U);
    EXPECT_NE(bench.optics.account().find("the nearest map answered 3 readings"), std::string::npos)
        << bench.optics.account();
    EXPECT_NE(bench.optics.account().find("2 traced"), std::string::npos) << bench.optics.account();
}

TEST(Photon_optics, TheMapUnusedForLongestMakesRoom) {
    std::size_t const one = map_at({0.0, 0.0, 1.0}, 1).bytes();
    Bench bench(0.02, 3 * one - 1); // room for two, whatever a map of few photons takes beyond them
    EXPECT_EQ(bench.answering(10.0, 0.0), 1);
    EXPECT_EQ(bench.answering(20.0, 0.0), 2);
    EXPECT_EQ(bench.answering(10.0, 0.0), 1);
    EXPECT_EQ(bench.answering(30.0, 0.0), 3) << "20 goes";
    EXPECT_EQ(bench.answering(10.0, 0.0), 1);
    EXPECT_EQ(bench.answering(20.0, 0.0), 4) << "traced again";
    EXPECT_NE(bench.optics.account().find("2 dropped"), std::string::npos) << bench.optics.account();
}

// The sample's axes do not turn the free beam: what lies off to one side in the lab stays there.
TEST(Photon_optics, FreeBeamStaysInTheLab) {
    Vector const beside = direction(178.0, 0.0); // the lab's +X side of straight through
    std::size_t traced = 0;
    Photon_optics const optics(
        [&](const Incident &incident, bool mounted) {
            ++traced;
            EXPECT_FALSE(mounted);
            EXPECT_EQ(incident.theta_deg, 0.0);
            return map_at(beside, 50);
        },
        {half_angle_rad, 0.02, std::size_t{1} << 30U});
    double const there = 0.5 / cap_sr(half_angle_rad);
    for (double const q1 : {0.0, 30.0, 120.0}) {
        for (double const q2 : {0.0, 90.0, 200.0}) {
            // sample <- lab = R_z(q2) R_y(q1).
            auto const seen = [&](const Vector &lab) {
                double const x = std::cos(q1 * deg) * lab.x + std::sin(q1 * deg) * lab.z;
                double const z = std::cos(q1 * deg) * lab.z - std::sin(q1 * deg) * lab.x;
                return Vector{std::cos(q2 * deg) * x - std::sin(q2 * deg) * lab.y,
                              std::sin(q2 * deg) * x + std::cos(q2 * deg) * lab.y, z};
            };
            EXPECT_NEAR(optics.apparent_dsf_per_sr(reading_at(q1, q2, seen(beside), false)), there, 1e-6 * there);
            EXPECT_EQ(optics.apparent_dsf_per_sr(reading_at(q1, q2, seen(direction(178.0, 180.0)), false)), 0.0);
        }
    }
    EXPECT_EQ(traced, 1U);
}

TEST(Photon_optics, PreparedDirectionsAreNotTracedAgain) {
    Bench bench;
    bench.optics.prepare(std::vector<Incident>{{45.0, 0.0}, {30.0, 10.0}});
    ASSERT_EQ(bench.asked.size(), 3U);
    EXPECT_FALSE(bench.asked[0].mounted);
    EXPECT_EQ(bench.answering(45.0, 0.0), 2);
    EXPECT_EQ(bench.answering(30.0, 10.0), 3);
    EXPECT_EQ(bench.answering(reading_at(0.0, 0.0, {0.0, 0.0, 1.0}, false)), 1);
    EXPECT_EQ(bench.asked.size(), 3U);
}

TEST(Incident_of, IsThePoseOfTheAxes) {
    for (double const q1 : {-4.0, 0.0, 45.0, 100.0, 180.0}) {
        for (double const q2 : {0.0, 30.0, 210.0}) {
            Reading const reading = reading_at(q1, q2, {0.0, 0.0, 1.0});
            Incident const pose = incident_of(reading.incident, reading.lab_up);
            EXPECT_NEAR(std::remainder(pose.theta_deg - q1, 360.0), 0.0, 1e-9) << q1 << " " << q2;
            EXPECT_NEAR(std::remainder(pose.phi_deg - q2, 360.0), 0.0, 1e-9) << q1 << " " << q2;
        }
    }
    // Another instrument's axes may tip the lab's up out of the sample's plane: its direction counts.
    Incident const tipped = incident_of({0.5, 0.0, std::sqrt(0.75)}, {-0.6 * std::sqrt(0.75), 0.8, 0.3});
    EXPECT_NEAR(tipped.theta_deg, 30.0, 1e-9);
    EXPECT_NEAR(tipped.phi_deg, 0.0, 1e-9);
}

} // namespace gonio::sim
