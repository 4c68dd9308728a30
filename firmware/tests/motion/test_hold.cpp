// test_hold.cpp: feed hold and underrun: on the path, within the limits, never a jump.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "knots.hpp"

namespace {

using namespace motion_test;

constexpr double dt_s = 0.002;
constexpr double duration_s = 50.0;

std::vector<gn_knot> path_knots() {
    return sinusoid_knots(1001, 50'000'000);
}

// Follows the targets cycle by cycle: largest speed and acceleration of any axis by differences, in limits.
struct Watch {
    std::array<double, 4> last{}, last_velocity{};
    int seen = 0;
    double speed = 0.0, acceleration = 0.0;

    void look(const std::array<double, 4> &target) {
        for (std::size_t axis = 0; axis < 4; axis++) {
            double const velocity = (target[axis] - last[axis]) / dt_s;
            if (seen >= 1) {
                speed = std::max(speed, std::fabs(velocity) / (30.0 * counts_per_deg));
            }
            if (seen >= 2) {
                acceleration =
                    std::max(acceleration, std::fabs(velocity - last_velocity[axis]) / dt_s / (60.0 * counts_per_deg));
            }
            last_velocity[axis] = velocity;
            last[axis] = target[axis];
        }
        seen++;
    }
};

void expect_on_curve(const Bench &bench) {
    double const time_s = (static_cast<double>(bench.path.time_ns) + bench.path.time_fraction_ns) * 1e-9;
    Curve_point const expected = sinusoids(time_s, duration_s);
    for (std::size_t axis = 0; axis < 4; axis++) {
        ASSERT_NEAR(bench.target[axis], expected.position[axis], 0.01);
    }
}

class Hold : public testing::TestWithParam<int> {};

TEST_P(Hold, StopsOnThePathWithinTheLimits) {
    auto const knots = path_knots();
    Bench bench;
    Watch watch;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots)) << bench.why;
    for (int cycle = 0; cycle < GetParam(); cycle++) {
        bench.step();
        watch.look(bench.target);
        ASSERT_TRUE(bench.feed(knots)) << bench.why;
    }
    gn_path_hold(&bench.path);
    EXPECT_EQ(bench.path.state, GN_PATH_HOLDING);
    int cycles = 0;
    while (bench.path.state == GN_PATH_HOLDING && cycles < 5000) {
        bench.step();
        watch.look(bench.target);
        expect_on_curve(bench);
        EXPECT_FALSE(bench.underrun);
        cycles++;
    }
    EXPECT_EQ(bench.path.state, GN_PATH_HELD);
    EXPECT_LE(cycles, 1000 + 1); // at the guaranteed rate of 0.5/s: 2 s
    EXPECT_LE(watch.speed, 1.0 + 1e-6);
    EXPECT_LE(watch.acceleration, 1.0 + 1e-6);
    auto const held_at = bench.target;
    bench.step();
    EXPECT_EQ(bench.target, held_at);
    char why[100];
    EXPECT_TRUE(gn_path_begin(&bench.path, 2, 10, why, sizeof why));
}

INSTANTIATE_TEST_SUITE_P(AtManyMoments, Hold,
                         testing::Values(1, 300, 700, 1000, 1501, 2222, 3000, 5050, 7777, 12345, 20000, 23000));

TEST(HoldOthers, WhileBufferingNothingMoves) {
    auto const knots = path_knots();
    Bench bench;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots, 10));
    gn_path_hold(&bench.path);
    EXPECT_EQ(bench.path.state, GN_PATH_HELD);
    EXPECT_EQ(bench.path.time_ns, 0);
}

TEST(HoldOthers, AfterIdleOrDoneHasNoEffect) {
    Bench bench;
    gn_path_hold(&bench.path);
    EXPECT_EQ(bench.path.state, GN_PATH_IDLE);
}

TEST(HoldOthers, NearTheEndThePathSimplyEnds) {
    auto const knots = path_knots();
    Bench bench;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots));
    for (int cycle = 0; cycle < 24'995; cycle++) {
        bench.step();
        ASSERT_TRUE(bench.feed(knots));
    }
    gn_path_hold(&bench.path);
    for (int cycle = 0; cycle < 20; cycle++) {
        bench.step();
    }
    EXPECT_EQ(bench.path.state, GN_PATH_DONE);
    EXPECT_EQ(bench.target[0], knots.back().position_counts[0]);
}

TEST(HoldOthers, ABadKnotHoldsTheRunningPath) {
    auto knots = path_knots();
    knots[400].position_counts[2] += 3.0 * counts_per_deg;
    Bench bench;
    ASSERT_TRUE(bench.begin(knots));
    bool fed = bench.feed(knots);
    int cycles = 0;
    while (fed && cycles++ < 20'000) {
        bench.step();
        fed = bench.feed(knots);
    }
    EXPECT_EQ(std::string(bench.why).find("axis 3, knot 400: "), 0U) << bench.why;
    EXPECT_EQ(bench.path.state, GN_PATH_HOLDING);
    while (bench.path.state == GN_PATH_HOLDING) {
        bench.step();
        expect_on_curve(bench);
    }
    EXPECT_EQ(bench.path.state, GN_PATH_HELD);
}

TEST(Underrun, SilenceEndsAtRestOnThePath) {
    auto const knots = path_knots();
    Bench bench;
    Watch watch;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots, 200)); // then silence: the buffer ends after 9.95 s of path
    int underruns = 0;
    int cycles = 0;
    while (bench.path.state != GN_PATH_HELD && cycles++ < 8'000) {
        bench.step();
        watch.look(bench.target);
        expect_on_curve(bench);
        underruns += bench.underrun ? 1 : 0;
        ASSERT_LE(bench.path.time_ns, knots[199].time_ns);
    }
    EXPECT_EQ(bench.path.state, GN_PATH_HELD);
    // From full feed at 0.5/s: 2 s, over the last second of path.
    EXPECT_NEAR(underruns, 1000, 3);
    EXPECT_NEAR(static_cast<double>(bench.path.time_ns), static_cast<double>(knots[199].time_ns), 1e4);
    EXPECT_LE(watch.speed, 1.0 + 1e-6);
    EXPECT_LE(watch.acceleration, 1.0 + 1e-6);
}

TEST(Underrun, RecoversWhenTheKnotsComeAgain) {
    auto const knots = path_knots();
    Bench bench;
    Watch watch;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots, 200));
    while (bench.path.feed > 0.2 || bench.path.state != GN_PATH_RUNNING) {
        bench.step();
        watch.look(bench.target);
        expect_on_curve(bench);
    }
    for (int cycle = 0; cycle < 25'000 && bench.path.state == GN_PATH_RUNNING; cycle++) {
        ASSERT_TRUE(bench.feed(knots)) << bench.why;
        bench.step();
        watch.look(bench.target);
        expect_on_curve(bench);
        ASSERT_FALSE(bench.underrun);
    }
    EXPECT_EQ(bench.path.state, GN_PATH_DONE);
    EXPECT_LE(watch.speed, 1.0 + 1e-6);
    EXPECT_LE(watch.acceleration, 1.0 + 1e-6);
}

TEST(Underrun, ATrickleOfKnotsNeverJumps) {
    // One knot of 50 ms of path every 100 ms: half feed in the mean, on the path, within the limits.
    auto const knots = path_knots();
    Bench bench;
    Watch watch;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots, 128));
    std::size_t allowed = 128;
    for (int cycle = 1; cycle < 60'000 && bench.path.state != GN_PATH_DONE; cycle++) {
        if (cycle % 50 == 0) {
            allowed++;
        }
        ASSERT_TRUE(bench.feed(knots, allowed)) << bench.why;
        bench.step();
        watch.look(bench.target);
        expect_on_curve(bench);
    }
    EXPECT_EQ(bench.path.state, GN_PATH_DONE);
    EXPECT_LE(watch.speed, 1.0 + 1e-6);
    EXPECT_LE(watch.acceleration, 1.0 + 1e-6);
}

} // namespace
