// test_sync.cpp: which TPDO belongs to which SYNC: in time, late, twice, absent, without an echo.
#include <gtest/gtest.h>

#include "scripted_can.hpp"

extern "C" {
#include "sync.h"
}

namespace gonio::test {
namespace {

constexpr std::int64_t us = 1000;
constexpr std::int64_t period_ns = 2000 * us;

struct Pairing : testing::Test {
    gn_motion_counters counters{};
    gn_sync sync{};
    gn_can_frame frame{};
    gn_pose pose{};

    void SetUp() override {
        gn_sync_init(&sync, 1500 * us, &counters);
        sync.expected_mask = 0x3;
    }
    std::int64_t start_of(int cycle) const { return cycle * period_ns; }
    void begin(int cycle) { gn_sync_begin(&sync, start_of(cycle), &frame); }
    bool echo(std::int64_t stamp_ns) {
        gn_can_frame copy = frame;
        copy.own_echo = true;
        copy.stamp_ns = stamp_ns;
        return gn_sync_on_echo(&sync, &copy);
    }
    void close(std::uint32_t known = 0x3) { ASSERT_TRUE(gn_sync_close(&sync, known, &pose)); }
    void good_cycle(int cycle, std::int32_t a, std::int32_t b) {
        begin(cycle);
        echo(start_of(cycle) + 90 * us);
        gn_sync_on_tpdo(&sync, 0, a, start_of(cycle) + 300 * us);
        gn_sync_on_tpdo(&sync, 1, b, start_of(cycle) + 420 * us);
        close();
    }
};

TEST_F(Pairing, pose_carries_the_echo_stamp_and_both_positions) {
    good_cycle(1, 111, -222);
    EXPECT_EQ(+pose.sync_time_ns, start_of(1) + 90 * us);
    EXPECT_EQ(+pose.sync_number, 1u);
    EXPECT_EQ(+pose.position_counts[0], 111);
    EXPECT_EQ(+pose.position_counts[1], -222);
    EXPECT_EQ(+pose.valid, 0x3);
    EXPECT_EQ(+pose.flags, 0);
    EXPECT_EQ(counters.syncs, 1u);
}

TEST_F(Pairing, echo_stamped_on_arrival_is_flagged_for_this_pose_only) {
    begin(1);
    frame.stamp_by_arrival = true;
    echo(start_of(1) + 90 * us);
    gn_sync_on_tpdo(&sync, 0, 1, start_of(1) + 300 * us);
    gn_sync_on_tpdo(&sync, 1, 2, start_of(1) + 420 * us);
    close();
    EXPECT_EQ(+pose.flags, GN_POSE_CLOCK_STEP);
    EXPECT_EQ(+pose.valid, 0x3);
    good_cycle(2, 3, 4);
    EXPECT_EQ(+pose.flags, 0);
}

TEST_F(Pairing, counter_runs_from_1_to_240) {
    for (int cycle = 1; cycle <= 241; cycle++) {
        begin(cycle);
        EXPECT_EQ(hex(frame).substr(0, 4), "080#");
        EXPECT_EQ(frame.data[0], cycle == 241 ? 1 : cycle);
        echo(start_of(cycle));
        close();
    }
}

TEST_F(Pairing, missing_tpdo_repeats_the_last_position_without_its_valid_bit) {
    good_cycle(1, 100, 200);
    begin(2);
    echo(start_of(2) + 90 * us);
    EXPECT_TRUE(gn_sync_on_tpdo(&sync, 0, 101, start_of(2) + 300 * us));
    close();
    EXPECT_EQ(+pose.valid, 0x1);
    EXPECT_EQ(+pose.flags, GN_POSE_TPDO_MISSING);
    EXPECT_EQ(+pose.position_counts[1], 200);
    EXPECT_EQ(counters.tpdo_missing, 1u);
}

TEST_F(Pairing, tpdo_behind_the_window_is_late_and_not_used) {
    good_cycle(1, 100, 200);
    begin(2);
    echo(start_of(2) + 90 * us);
    EXPECT_TRUE(gn_sync_on_tpdo(&sync, 0, 101, start_of(2) + 1590 * us)); // the window's last instant
    EXPECT_FALSE(gn_sync_on_tpdo(&sync, 1, 201, start_of(2) + 1590 * us + 1));
    close();
    EXPECT_EQ(+pose.valid, 0x1);
    EXPECT_EQ(+pose.flags, GN_POSE_TPDO_LATE);
    EXPECT_EQ(+pose.position_counts[1], 200);
    EXPECT_EQ(counters.tpdo_late, 1u);
    EXPECT_EQ(counters.tpdo_missing, 0u);
}

TEST_F(Pairing, tpdo_between_the_next_sync_and_its_echo_is_late) {
    good_cycle(1, 100, 200);
    begin(2);
    EXPECT_FALSE(gn_sync_on_tpdo(&sync, 1, 199, start_of(2) + 50 * us));
    echo(start_of(2) + 200 * us);
    EXPECT_TRUE(gn_sync_on_tpdo(&sync, 0, 101, start_of(2) + 500 * us));
    EXPECT_TRUE(gn_sync_on_tpdo(&sync, 1, 201, start_of(2) + 600 * us));
    close();
    EXPECT_EQ(+pose.valid, 0x3);
    EXPECT_EQ(+pose.flags, GN_POSE_TPDO_LATE);
    EXPECT_EQ(+pose.position_counts[1], 201);
}

TEST_F(Pairing, tpdo_that_comes_after_the_next_echo_spoils_that_position_in_any_order) {
    for (bool const late_first : {true, false}) {
        counters = {};
        good_cycle(1, 100, 200);
        begin(2);
        echo(start_of(2) + 90 * us);
        gn_sync_on_tpdo(&sync, 0, 101, start_of(2) + 300 * us);
        gn_sync_on_tpdo(&sync, 1, late_first ? 195 : 201, start_of(2) + 310 * us);
        gn_sync_on_tpdo(&sync, 1, late_first ? 201 : 195, start_of(2) + 900 * us);
        close();
        EXPECT_EQ(+pose.valid, 0x1);
        EXPECT_EQ(+pose.flags, GN_POSE_TPDO_DUPLICATE);
        EXPECT_EQ(+pose.position_counts[1], 200);
        EXPECT_EQ(counters.tpdo_duplicate, 1u);
    }
}

TEST_F(Pairing, lost_echo_leaves_no_valid_position) {
    good_cycle(1, 100, 200);
    begin(2);
    EXPECT_FALSE(gn_sync_on_tpdo(&sync, 0, 101, start_of(2) + 300 * us));
    close();
    EXPECT_EQ(+pose.valid, 0);
    EXPECT_TRUE(pose.flags & GN_POSE_ECHO_LOST);
    EXPECT_EQ(+pose.sync_time_ns, start_of(2));
    EXPECT_EQ(+pose.position_counts[0], 100);
    EXPECT_EQ(counters.sync_echoes_lost, 1u);
    EXPECT_EQ(sync.echoes_lost_in_a_row, 1u);
    good_cycle(3, 103, 203);
    EXPECT_EQ(sync.echoes_lost_in_a_row, 0u);
    EXPECT_EQ(+pose.flags, 0);
}

TEST_F(Pairing, echo_of_an_older_sync_is_not_the_last_ones) {
    begin(1);
    gn_can_frame old = frame;
    old.own_echo = true;
    close();
    begin(2);
    old.stamp_ns = start_of(2) + 10 * us;
    EXPECT_FALSE(gn_sync_on_echo(&sync, &old));
    EXPECT_TRUE(echo(start_of(2) + 90 * us));
    EXPECT_FALSE(echo(start_of(2) + 95 * us));
    EXPECT_EQ(sync.echo_ns, start_of(2) + 90 * us);
}

TEST_F(Pairing, unknown_position_is_flagged_and_unexpected_axes_are_ignored) {
    begin(1);
    echo(start_of(1));
    EXPECT_FALSE(gn_sync_on_tpdo(&sync, 2, 5, start_of(1) + 100 * us));
    gn_sync_on_tpdo(&sync, 0, 1, start_of(1) + 100 * us);
    gn_sync_on_tpdo(&sync, 1, 2, start_of(1) + 100 * us);
    close(0x1);
    EXPECT_EQ(+pose.flags, GN_POSE_POSITION_UNKNOWN);
    EXPECT_EQ(+pose.valid, 0x3);
}

TEST_F(Pairing, no_pose_before_the_drives_are_operational) {
    sync.expected_mask = 0;
    begin(1);
    echo(start_of(1));
    EXPECT_FALSE(gn_sync_close(&sync, 0, &pose));
}

} // namespace
} // namespace gonio::test
