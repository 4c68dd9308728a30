// test_strobe.cpp: the strobe line's latency is one-sided and exponential; losses and disturbances are as asked for.
#include <vector>

#include <gtest/gtest.h>

#include "strobe.hpp"

namespace gonio::sim {
namespace {

struct Line {
    explicit Line(double latency_us)
        : strobe(
              scheduler, 7, latency_us, [this](const gn_edge &e) { edges.push_back(e); },
              [this](bool high) { levels.emplace_back(scheduler.now_ns(), high); }) {}
    // A pulse of 2.5 ms every 10 ms.
    void pulses(int count) {
        for (int i = 0; i < count; ++i) {
            scheduler.after(0, [this] { strobe.change(true); });
            scheduler.after(2500000, [this] { strobe.change(false); });
            std::int64_t const end_ns = scheduler.now_ns() + 10000000;
            while (scheduler.run_one(end_ns)) {
            }
        }
    }
    Scheduler scheduler;
    std::vector<gn_edge> edges;
    std::vector<std::pair<std::int64_t, bool>> levels;
    Strobe_line strobe;
};

} // namespace

TEST(Strobe, LatencyIsOneSidedWithTheStatedMean) {
    Line line(50.0);
    line.pulses(4000);
    ASSERT_EQ(line.edges.size(), 8000U);
    double sum_us = 0.0;
    std::int64_t least_ns = INT64_MAX;
    for (std::size_t i = 0; i < line.edges.size(); ++i) {
        std::int64_t const true_ns = static_cast<std::int64_t>(i / 2) * 10000000 + (i % 2 == 0 ? 0 : 2500000);
        std::int64_t const late_ns = line.edges[i].stamp_ns - true_ns;
        ASSERT_GE(late_ns, 0);
        least_ns = std::min(least_ns, late_ns);
        sum_us += 1e-3 * static_cast<double>(late_ns);
        EXPECT_EQ(line.edges[i].number, i + 1);
        EXPECT_EQ(line.edges[i].rising, i % 2 == 0);
    }
    // The mean of n exponentials scatters by mean / sqrt(n): 0.56 us; five times that.
    EXPECT_NEAR(sum_us / 8000.0, 50.0, 2.8);
    EXPECT_LT(least_ns, 200) << "the least of 8000 is about 50 us / 8000";
}

TEST(Strobe, CountedLossesShowInTheNumbersOthersDoNot) {
    Line line(0.0);
    line.pulses(2);
    line.strobe.lose(1, true);
    line.pulses(2);
    ASSERT_EQ(line.edges.size(), 6U);
    EXPECT_EQ(line.edges[4].number, 7U);
    line.strobe.lose(2, false);
    line.pulses(3);
    ASSERT_EQ(line.edges.size(), 8U);
    EXPECT_EQ(line.edges[6].number, 9U);
    EXPECT_TRUE(line.edges[6].rising);
    EXPECT_EQ(line.strobe.edges_lost(), 6U);
}

TEST(Strobe, ADisturbanceIsAShortPulse) {
    Line line(0.0);
    line.pulses(1);
    line.strobe.disturb();
    line.pulses(1);
    ASSERT_EQ(line.edges.size(), 6U);
    EXPECT_TRUE(line.edges[2].rising || line.edges[3].rising);
    EXPECT_EQ(line.edges[5].number, 6U);
}

TEST(Strobe, ARealLineShowsTheLevelAtOnceAndNoLostPulse) {
    Line line(50.0);
    line.pulses(1);
    line.strobe.lose(1, true);
    line.pulses(2);
    EXPECT_EQ(line.levels, (std::vector<std::pair<std::int64_t, bool>>{
                               {0, true}, {2500000, false}, {20000000, true}, {22500000, false}}));
}

TEST(Strobe, AStuckLineStaysHighAndFollowsAgainWhenFreed) {
    Line line(0.0);
    line.pulses(1);
    line.strobe.stick(true);
    EXPECT_TRUE(line.strobe.level());
    line.pulses(3);
    EXPECT_TRUE(line.strobe.level());
    EXPECT_EQ(line.edges.size(), 3U) << "one pulse, and the rise to where it sticks";
    line.strobe.stick(false);
    EXPECT_FALSE(line.strobe.level());
    line.pulses(1);
    EXPECT_EQ(line.edges.size(), 6U);
}

TEST(Strobe, ADoubledPulseIsFollowedByOneOfHalfItsWidth) {
    Line line(0.0);
    line.strobe.double_pulses(2);
    line.pulses(3);
    ASSERT_EQ(line.levels.size(), 10U) << "two doubled, one plain";
    EXPECT_EQ(line.levels[2], (std::pair<std::int64_t, bool>{2500000 + 625000, true}));
    EXPECT_EQ(line.levels[3], (std::pair<std::int64_t, bool>{2500000 + 1875000, false}));
    EXPECT_EQ(line.levels[8], (std::pair<std::int64_t, bool>{20000000, true}));
}

} // namespace gonio::sim
