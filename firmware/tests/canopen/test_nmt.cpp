// test_nmt.cpp: NMT commands, boot-up and heartbeats, as frames.
#include <gtest/gtest.h>

#include "scripted_can.hpp"

extern "C" {
#include "nmt.h"
}

namespace gonio::test {
namespace {

constexpr std::int64_t ms = 1'000'000;

TEST(Nmt, commands_are_the_standards_frames) {
    Scripted_can can;
    gn_nmt_send(&can.port, GN_NMT_START, 4);
    gn_nmt_send(&can.port, GN_NMT_RESET_COMMUNICATION, 2);
    EXPECT_EQ(hex(can.sent[0]), "000#0104");
    EXPECT_EQ(hex(can.sent[1]), "000#8202");
}

TEST(Nmt, own_heartbeat_starts_with_the_boot_up_message) {
    Scripted_can can;
    gn_heartbeat heartbeat{};
    gn_heartbeat_process(&heartbeat, &can.port, 0);
    EXPECT_TRUE(can.sent.empty());
    heartbeat.period_ns = 100 * ms;
    for (std::int64_t now = 0; now <= 200 * ms; now += ms) {
        gn_heartbeat_process(&heartbeat, &can.port, now);
    }
    ASSERT_EQ(can.sent.size(), 3u);
    EXPECT_EQ(hex(can.sent[0]), "77F#00");
    EXPECT_EQ(hex(can.sent[1]), "77F#05");
    EXPECT_EQ(hex(can.sent[2]), "77F#05");
}

TEST(Nmt, node_is_lost_when_its_heartbeat_is_overdue) {
    gn_node node{};
    gn_can_frame const alive = frame_of(0x701, {0x7F});
    EXPECT_FALSE(gn_node_lost(&node, 300 * ms, 1000 * ms)); // nobody waits for it yet
    gn_node_monitor(&node, 0);
    EXPECT_FALSE(gn_node_lost(&node, 300 * ms, 300 * ms));
    EXPECT_TRUE(gn_node_lost(&node, 300 * ms, 301 * ms));
    gn_node_on_frame(&node, &alive, 250 * ms);
    EXPECT_FALSE(gn_node_lost(&node, 300 * ms, 550 * ms));
    EXPECT_TRUE(gn_node_lost(&node, 300 * ms, 551 * ms));
    EXPECT_EQ(node.nmt_state, GN_NMT_STATE_PRE_OPERATIONAL);
}

TEST(Nmt, boot_up_is_expected_once_and_a_reset_later) {
    gn_node node{};
    gn_can_frame const boot_up = frame_of(0x701, {0x00});
    gn_node_expect_boot_up(&node);
    gn_node_on_frame(&node, &boot_up, 0);
    EXPECT_TRUE(node.booted);
    EXPECT_FALSE(node.reset);
    gn_node_monitor(&node, 0);
    gn_node_on_frame(&node, &boot_up, ms);
    EXPECT_TRUE(node.reset);
}

TEST(Nmt, frames_of_another_length_are_no_heartbeats) {
    gn_node node{};
    gn_can_frame const odd = frame_of(0x701, {0x05, 0x00});
    gn_node_on_frame(&node, &odd, ms);
    EXPECT_EQ(node.heard_ns, 0);
}

} // namespace
} // namespace gonio::test
