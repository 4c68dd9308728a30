// test_nmt.cpp: boot-up, NMT states, heartbeats both ways, error behaviour, error history.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace gonio::sim {
namespace {

constexpr std::uint32_t tool_heartbeat = 0x700 + 127;

// 0x1016: node 127 within 50 ms.
void watch_tool(Bench &bench) {
    ASSERT_EQ(bench.write(0x1016, 1, 127 << 16 | 50, 4), 0U);
}

TEST(Nmt, a_drive_boots_up_and_waits_in_pre_operational) {
    Bench bench(Bench::standard(4));
    const auto boot_up = bench.frames_with(0x704);
    ASSERT_EQ(boot_up.size(), 1U);
    EXPECT_EQ(boot_up[0].length, 1);
    EXPECT_EQ(boot_up[0].data[0], 0);
    EXPECT_EQ(bench.drive().nmt_state(), 127);
    EXPECT_EQ(bench.drive().counters().boot_ups, 1U);
}

TEST(Nmt, commands_change_the_state_of_the_addressed_node) {
    Bench bench(Bench::standard(4));
    bench.nmt(0x01, 5);
    EXPECT_EQ(bench.drive().nmt_state(), 127);
    bench.nmt(0x01, 4);
    EXPECT_EQ(bench.drive().nmt_state(), 5);
    bench.nmt(0x02, 0);
    EXPECT_EQ(bench.drive().nmt_state(), 4);
    EXPECT_TRUE(bench.exchange({0x40, 0, 0x10, 0, 0, 0, 0, 0}, 4).empty()); // no SDO when stopped
    bench.nmt(0x80, 4);
    EXPECT_EQ(bench.drive().nmt_state(), 127);
    bench.nmt(0x55, 4);
    EXPECT_EQ(bench.drive().nmt_state(), 127);
}

TEST(Nmt, resets_bring_back_power_up_values_as_far_as_they_reach) {
    Bench bench(Bench::standard());
    bench.write(0x6083, 0, 5000, 4);
    bench.write(0x1400, 5, 9, 2);
    bench.nmt(0x82);
    bench.run_ms(20);
    EXPECT_EQ(bench.frames_with(0x701).size(), 2U); // boot-up again
    EXPECT_EQ(bench.read(0x1400, 5), 0);
    EXPECT_EQ(bench.read(0x6083), 5000);
    bench.nmt(0x81);
    EXPECT_EQ(bench.drive().nmt_state(), 0);
    EXPECT_TRUE(bench.exchange({0x40, 0, 0x10, 0, 0, 0, 0, 0}).empty());
    bench.run_ms(100);
    EXPECT_EQ(bench.read(0x6083), 66667);
}

TEST(Heartbeat, is_produced_with_its_period_and_the_state) {
    Bench bench(Bench::standard());
    bench.write(0x1017, 0, 100, 2);
    bench.run_ms(450);
    bench.nmt(0x01);
    bench.run_ms(200);
    const auto frames = bench.frames_with(0x701);
    ASSERT_GE(frames.size(), 6U);
    EXPECT_EQ(frames[1].data[0], 127);
    EXPECT_EQ(frames.back().data[0], 5);
    for (std::size_t k = 2; k < frames.size(); ++k) {
        EXPECT_NEAR(static_cast<double>(frames[k].stamp_ns - frames[k - 1].stamp_ns), 100e6, 1.2e6);
    }
}

TEST(Heartbeat, a_lost_producer_is_an_emergency_and_ends_operational) {
    Bench bench(Bench::standard());
    watch_tool(bench);
    bench.nmt(0x01);
    bench.run_ms(200);
    EXPECT_EQ(bench.drive().nmt_state(), 5); // not watched before its first heartbeat
    bench.send(tool_heartbeat, {5});
    bench.run_ms(45);
    EXPECT_TRUE(bench.emergencies().empty());
    bench.run_ms(10);
    EXPECT_EQ(bench.emergencies(), (std::vector<std::uint16_t>{0x8130}));
    EXPECT_EQ(bench.drive().nmt_state(), 127);
    bench.run_ms(300);
    EXPECT_EQ(bench.emergencies().size(), 1U); // once per loss
    bench.send(tool_heartbeat, {5});
    bench.run_ms(2);
    EXPECT_EQ(bench.emergencies().back(), 0x0000);
}

TEST(Heartbeat, the_reaction_to_a_loss_is_that_of_0x1029) {
    for (const auto &[option, state] : {std::pair{0, 127}, std::pair{1, 5}, std::pair{2, 4}}) {
        Bench bench(Bench::standard());
        watch_tool(bench);
        bench.write(0x1029, 1, option, 1);
        bench.nmt(0x01);
        bench.send(tool_heartbeat, {5});
        bench.run_ms(100);
        EXPECT_EQ(bench.drive().nmt_state(), state) << "0x1029:01 = " << option;
    }
}

TEST(Heartbeat, the_drive_reacts_as_0x6007_says) {
    for (const auto &[option, bits] :
         {std::pair{0, 0x27}, std::pair{1, 0x08}, std::pair{2, 0x40}, std::pair{3, 0x07}}) {
        Bench bench(Bench::standard());
        bench.write(0x1029, 1, 1, 1);
        bench.write(0x6007, 0, option, 2);
        bench.write(0x605A, 0, 6, 2);
        bench.enable();
        watch_tool(bench);
        bench.send(tool_heartbeat, {5});
        bench.run_ms(100);
        EXPECT_EQ(bench.drive().statusword() & 0x6FU, bits) << "0x6007 = " << option;
    }
}

TEST(Heartbeat, without_0x6007_the_connection_lost_is_a_fault) {
    Bench bench(Bench::standard(1, "basic"));
    bench.enable();
    watch_tool(bench);
    bench.send(tool_heartbeat, {5});
    bench.run_ms(100);
    EXPECT_EQ(bench.drive().statusword() & 0x6FU, 0x08);
    EXPECT_EQ(bench.read(0x603F) & 0xFFFF, 0x8130);
    EXPECT_EQ(bench.drive().nmt_state(), 127);
}

TEST(Heartbeat, one_producer_cannot_be_watched_twice) {
    Bench bench(Bench::standard());
    watch_tool(bench);
    EXPECT_EQ(bench.write(0x1016, 2, 127 << 16 | 80, 4), 0x06040043U);
    EXPECT_EQ(bench.write(0x1016, 2, 126 << 16 | 80, 4), 0U);
}

TEST(Nmt, stopping_an_enabled_drive_aborts_its_connection) {
    Bench bench(Bench::standard());
    bench.write(0x6007, 0, 2, 2);
    bench.enable();
    ASSERT_TRUE(bench.drive().energised());
    bench.nmt(0x02);
    bench.run_ms(5);
    EXPECT_FALSE(bench.drive().energised());
}

TEST(Emcy, history_keeps_the_newest_first_and_is_cleared_by_writing_0) {
    Bench bench(Bench::standard());
    EXPECT_EQ(bench.read_abort(0x1003, 1), 0x08000024U); // nothing there
    bench.drive().raise_emcy(0x2310);
    bench.drive().raise_emcy(0x4210);
    bench.run_ms(5);
    EXPECT_EQ(bench.emergencies(), (std::vector<std::uint16_t>{0x2310, 0x4210}));
    EXPECT_EQ(bench.read(0x1003, 0), 2);
    EXPECT_EQ(bench.read(0x1003, 1) & 0xFFFF, 0x4210);
    EXPECT_EQ(bench.read(0x1003, 2) & 0xFFFF, 0x2310);
    EXPECT_EQ(bench.read_abort(0x1003, 3), 0x08000024U);
    EXPECT_EQ(bench.read(0x1001), 0x0B); // generic, current, temperature
    EXPECT_EQ(bench.write(0x1003, 0, 3, 1), 0x06090030U);
    EXPECT_EQ(bench.write(0x1003, 0, 0, 1), 0U);
    EXPECT_EQ(bench.read(0x1003, 0), 0);
}

TEST(Emcy, a_disabled_identifier_keeps_emergencies_off_the_bus) {
    Bench bench(Bench::standard());
    EXPECT_EQ(bench.write(0x1014, 0, 0x80000081, 4), 0U);
    bench.drive().raise_emcy(0x2310);
    bench.run_ms(5);
    EXPECT_TRUE(bench.emergencies().empty());
    EXPECT_EQ(bench.read(0x603F) & 0xFFFF, 0x2310);
}

TEST(Drive, an_absent_one_never_answers_and_a_silenced_one_says_nothing_more) {
    Drive_config config = Bench::standard();
    config.absent = true;
    Bench bench(config);
    bench.run_ms(500);
    EXPECT_TRUE(bench.recorder.frames.empty());
    EXPECT_TRUE(bench.exchange({0x40, 0, 0x10, 0, 0, 0, 0, 0}).empty());

    Bench other(Bench::standard());
    other.write(0x1017, 0, 10, 2);
    other.drive().silence(true);
    const std::size_t before = other.recorder.frames.size();
    other.run_ms(100);
    EXPECT_EQ(other.recorder.frames.size(), before);
    other.drive().silence(false);
    other.run_ms(100);
    EXPECT_GE(other.recorder.frames.size(), before + 9);
}

} // namespace
} // namespace gonio::sim
