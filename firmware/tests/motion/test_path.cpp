// test_path.cpp: buffering, motion along the knots, and the refusals.
#include <gtest/gtest.h>

#include <cmath>

#include "knots.hpp"

namespace {

using namespace motion_test;

TEST(Path, HitsEveryKnotInAHundredThousandSteps) {
    auto const knots = sinusoid_knots(4001, 50'000'000); // 200 s, 100,000 cycles of 2 ms
    Bench bench;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots)) << bench.why;
    std::size_t hit = 0;
    for (int cycle = 1; cycle <= 100'000; cycle++) {
        bench.step();
        ASSERT_FALSE(bench.underrun) << cycle;
        ASSERT_TRUE(bench.feed(knots)) << bench.why;
        if (cycle % 25 == 0) {
            const gn_knot &knot = knots[static_cast<std::size_t>(cycle) / 25];
            ASSERT_EQ(bench.path.time_ns, knot.time_ns);
            for (std::size_t axis = 0; axis < 4; axis++) {
                ASSERT_NEAR(bench.target[axis], knot.position_counts[axis], 1e-9 * 25 * counts_per_deg);
            }
            hit++;
        }
    }
    EXPECT_EQ(hit, 4000U);
    EXPECT_EQ(bench.path.state, GN_PATH_DONE);
}

TEST(Path, StaysOnTheCurveBetweenKnots) {
    auto const knots = sinusoid_knots(401, 50'000'000);
    Bench bench;
    ASSERT_TRUE(bench.begin(knots));
    for (int cycle = 1; cycle <= 10'000; cycle++) {
        ASSERT_TRUE(bench.feed(knots)) << bench.why;
        bench.step();
        Curve_point const expected = sinusoids(static_cast<double>(bench.path.time_ns) * 1e-9, 20.0);
        for (std::size_t axis = 0; axis < 4; axis++) {
            ASSERT_NEAR(bench.target[axis], expected.position[axis], 0.01);
        }
    }
}

TEST(Path, StartsAtRestWithTheFirstStepOfTheCurve) {
    auto const knots = sinusoid_knots(401, 50'000'000);
    Bench bench;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots));
    bench.step();
    for (std::size_t axis = 0; axis < 4; axis++) {
        // The ramp grows with t^4: nothing measurable moves in the first cycle.
        EXPECT_NEAR(bench.target[axis], knots[0].position_counts[axis], 1e-3);
    }
}

TEST(Path, WaitsForHalfTheBufferAndTheStoppingDistance) {
    auto const knots = sinusoid_knots(1001, 50'000'000);
    Bench bench;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots, GN_PATH_CAPACITY / 2 - 1));
    bench.step();
    EXPECT_EQ(bench.path.state, GN_PATH_BUFFERING);
    ASSERT_TRUE(bench.feed(knots, GN_PATH_CAPACITY / 2));
    bench.step();
    EXPECT_EQ(bench.path.state, GN_PATH_RUNNING);
    EXPECT_EQ(bench.path.feed, 1.0);
}

TEST(Path, KnotsTooDenseForTheStoppingDistanceStartSlower) {
    auto const knots = sinusoid_knots(5001, 2'000'000); // a full buffer is 0.51 s, the stopping distance 1 s
    Bench bench;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots)) << bench.why;
    double fastest = 0.0;
    for (int cycle = 0; cycle < 40'000 && bench.path.state != GN_PATH_DONE; cycle++) {
        bench.step();
        ASSERT_TRUE(bench.feed(knots)) << bench.why;
        if (bench.path.received < bench.path.knot_count) {
            fastest = std::fmax(fastest, bench.path.feed);
        }
    }
    EXPECT_EQ(bench.path.state, GN_PATH_DONE);
    // feed^2 / (2 * 0.5 / s) = 0.51 s at most.
    EXPECT_LE(fastest, std::sqrt(0.511));
    EXPECT_GE(fastest, std::sqrt(0.490));
}

TEST(Path, CreditFollowsTheKnotsLeftBehind) {
    auto const knots = sinusoid_knots(1001, 50'000'000);
    Bench bench;
    EXPECT_EQ(gn_path_credit(&bench.path), 0U);
    ASSERT_TRUE(bench.begin(knots));
    EXPECT_EQ(gn_path_credit(&bench.path), GN_PATH_CAPACITY);
    ASSERT_TRUE(bench.feed(knots));
    EXPECT_EQ(bench.sent, GN_PATH_CAPACITY);
    EXPECT_FALSE(bench.push(GN_PATH_CAPACITY, knots[GN_PATH_CAPACITY], {}));
    EXPECT_STREQ(bench.why, "knot 256: beyond the credit of 256");
}

TEST(Path, CreditGrowsWithEveryKnotPassed) {
    auto const knots = sinusoid_knots(1001, 50'000'000);
    Bench bench;
    ASSERT_TRUE(bench.begin(knots));
    ASSERT_TRUE(bench.feed(knots));
    for (int cycle = 0; cycle < 250; cycle++) {
        bench.step();
    }
    EXPECT_EQ(bench.path.used, 10U); // 0.5 s of 50 ms
    EXPECT_EQ(gn_path_credit(&bench.path), GN_PATH_CAPACITY + 10U);
}

TEST(Path, ASecondPathWaitsForTheFirst) {
    std::vector<gn_knot> const knots = {rest(0, {}), rest(1'000'000'000, {1000, 0, 0, 0})};
    Bench bench;
    EXPECT_EQ(bench.refusal(knots), "");
    EXPECT_FALSE(bench.begin(knots));
    EXPECT_STREQ(bench.why, "path 1 cannot begin: path 1 is not over");
    for (int cycle = 0; cycle < 500; cycle++) {
        bench.step();
    }
    EXPECT_EQ(bench.path.state, GN_PATH_DONE);
    EXPECT_EQ(bench.target[0], 1000.0);
    EXPECT_TRUE(bench.begin(knots));
}

TEST(Path, RefusalsNameAxisKnotAndLimit) {
    Bench bench;
    double const d = counts_per_deg;
    std::int64_t const ms = 1'000'000;
    EXPECT_EQ(bench.refusal({rest(0, {}), rest(9000 * ms, {0, 0, 0, 90 * d})}),
              "axis 4, knot 1: position 100000 counts is over the limit of 94444");
    EXPECT_EQ(bench.refusal({rest(0, {}), rest(9000 * ms, {-90 * d, 0, 0, 0})}),
              "axis 1, knot 1: position -100000 counts is under the limit of -94444");
    // Rest to rest: largest speed 15/8 of the mean: 40 degrees in 2 s are 37.5 degrees/s.
    EXPECT_EQ(bench.refusal({rest(0, {}), rest(2000 * ms, {0, 40 * d, 0, 0})}),
              "axis 2, knot 1: velocity 41667 counts/s is over the limit of 33333");
    // Acceleration 10/sqrt(3) of the mean: 4 degrees in 0.5 s are 92 degrees/s2.
    std::string const sentence = bench.refusal({rest(0, {}), rest(500 * ms, {0, 0, 4 * d, 0})});
    EXPECT_EQ(sentence.find("axis 3, knot 1: acceleration with the feed hold's share 10"), 0U) << sentence;
    EXPECT_NE(sentence.find("is over the limit of 66667"), std::string::npos) << sentence;
    EXPECT_EQ(bench.refusal({rest(0, {}), rest(500'000, {})}),
              "knot 1: comes 500000 ns after knot 0, the least is 1000000 ns");
    EXPECT_EQ(bench.refusal({rest(0, {}), rest(0, {})}), "knot 1: comes 0 ns after knot 0, the least is 1000000 ns");
    EXPECT_EQ(bench.refusal({rest(5, {}), rest(500 * ms, {})}), "knot 0: its time must be 0, not 5 ns");
    EXPECT_EQ(bench.refusal({knot_of({{}, {0, 7, 0, 0}, {}}, 0), rest(500 * ms, {})}),
              "axis 2, knot 0: a path begins and ends at rest, not at 7 counts/s and 0 counts/s2");
    EXPECT_EQ(bench.refusal({rest(0, {}), knot_of({{}, {}, {0, 0, 0, 9}}, 500 * ms)}),
              "axis 4, knot 1: a path begins and ends at rest, not at 0 counts/s and 9 counts/s2");
    EXPECT_EQ(bench.refusal({rest(0, {}), rest(500 * ms, {0, std::nan(""), 0, 0})}),
              "axis 2, knot 1: a value is no number or beyond all limits");
    EXPECT_EQ(bench.path.state, GN_PATH_IDLE);
}

TEST(Path, RefusesKnotsOutOfOrderAndElsewhere) {
    Bench bench;
    std::vector<gn_knot> const knots = {rest(0, {}), rest(500'000'000, {}), rest(900'000'000, {})};
    ASSERT_TRUE(bench.begin(knots));
    EXPECT_FALSE(bench.push(1, knots[1], {}));
    EXPECT_STREQ(bench.why, "knot 1: out of order, 0 was expected");
    ASSERT_TRUE(bench.begin(knots));
    EXPECT_FALSE(bench.push(0, knots[0], {0, 0, 500, 0}));
    EXPECT_STREQ(bench.why, "axis 3, knot 0: starts at 0 counts, the axis stands at 500");
    EXPECT_FALSE(bench.push(0, knots[0], {}));
    EXPECT_STREQ(bench.why, "knot 0: no path is under way");
}

TEST(Path, ALegalPathAtItsLimitsIsTaken) {
    // To the position limit itself, at exactly the largest allowed speed: 15/8 * 85 / T = 30.
    Bench bench;
    double const duration_s = 15.0 / 8.0 * 85.0 / 30.0;
    std::vector<gn_knot> const knots = {
        rest(0, {}), rest(static_cast<std::int64_t>(std::ceil(duration_s * 1e9)), {0, 0, 0, 85 * counts_per_deg})};
    EXPECT_EQ(bench.refusal(knots), "");
}

TEST(Path, AnAxisOutsideItsLimitsMayComeBackButNotGoFarther) {
    Bench bench;
    std::array<double, 4> const switch_at = {-86 * counts_per_deg, 0, 0, 0};
    EXPECT_EQ(bench.refusal({rest(0, switch_at), rest(9'000'000'000, {})}), "");
    Bench other;
    EXPECT_NE(other.refusal({rest(0, switch_at), rest(9'000'000'000, {-87 * counts_per_deg, 0, 0, 0})}), "");
}

TEST(Path, ARefusalNamesTheZone) {
    Bench bench;
    gonio_Zone zone = gonio_Zone_init_zero;
    zone.index = 3;
    std::snprintf(zone.name, sizeof zone.name, "holder");
    zone.half_spaces_count = 2;
    zone.half_spaces[0] = {4, {0, 0, -1, 0}, -20 * counts_per_deg}; // azimuth 20 or more
    zone.half_spaces[1] = {4, {0, 0, 0, 1}, 0.0};                   // elevation 0 or less
    ASSERT_TRUE(gn_path_set_zone(&bench.path, &zone));
    EXPECT_EQ(bench.refusal({rest(0, {}), rest(5'000'000'000, {0, 0, 30 * counts_per_deg, 0})}),
              "knot 1: on the way there the arm would enter \"holder\"");
    // Around it, above.
    std::array<double, 4> const above = {0, 0, 0, 10 * counts_per_deg};
    std::array<double, 4> const beyond = {0, 0, 30 * counts_per_deg, 10 * counts_per_deg};
    EXPECT_EQ(bench.refusal({rest(0, {}), rest(5'000'000'000, above), rest(10'000'000'000, beyond)}), "");
    zone.index = GN_PATH_ZONES;
    EXPECT_FALSE(gn_path_set_zone(&bench.path, &zone));
    zone.index = 0;
    zone.half_spaces_count = 0;
    EXPECT_FALSE(gn_path_set_zone(&bench.path, &zone));
}

} // namespace
