// test_feed.cpp: the law of the feed: rates within the limits, and never more feed than the buffer can stop.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

extern "C" {
#include "feed.h"
}

namespace {

std::array<gn_axis_limits, 4> limits() {
    std::array<gn_axis_limits, 4> all{};
    all.fill({-1e6, 1e6, 30e3, 60e3, nullptr});
    return all;
}

TEST(Feed, TheRateLeavesEveryAxisWithinItsAcceleration) {
    auto const all = limits();
    for (double velocity : {0.0, 1e3, 10e3, 30e3}) {
        for (double acceleration : {0.0, 10e3, 45e3}) {
            std::array<gn_state, 4> axes{};
            axes[2] = {0.0, velocity, acceleration};
            double const rate = gn_feed_rate_per_s(all.data(), axes.data(), 1.0);
            EXPECT_LE(acceleration + rate * velocity, 60e3 + 1e-6);
            EXPECT_GE(rate, GN_PATH_HOLD_RATE_PER_S);
        }
    }
}

TEST(Feed, ConstantSpeedStopsFasterThanTheGuarantee) {
    auto const all = limits();
    std::array<gn_state, 4> axes{};
    axes[0] = {0.0, 30e3, 0.0};
    EXPECT_NEAR(gn_feed_rate_per_s(all.data(), axes.data(), 1.0), 0.9 * 60e3 / 30e3, 1e-9);
}

TEST(Feed, RunningOutOfPathEndsAtItsEndAndNotBeyond) {
    // Uniform deceleration at the guaranteed rate: the path that is left is always feed^2 / (2 rate) or more.
    double left_s = 3.0;
    double feed = 1.0;
    double slowest_change = 0.0;
    double const dt_s = 0.002;
    for (int cycle = 0; cycle < 5000; cycle++) {
        bool limited = false;
        double const next = gn_feed_next(feed, 1.0, 2.0, left_s, dt_s, &limited);
        slowest_change = std::fmin(slowest_change, (next - feed) / dt_s);
        left_s -= 0.5 * (feed + next) * dt_s;
        feed = next;
        ASSERT_GE(left_s + 1e-12, gn_feed_stopping_s(feed));
        ASSERT_EQ(limited, feed < 1.0);
    }
    EXPECT_LT(left_s, 1e-6);
    EXPECT_LT(feed, 1e-3);
    EXPECT_GE(slowest_change, -GN_PATH_HOLD_RATE_PER_S - 1e-6);
}

} // namespace
