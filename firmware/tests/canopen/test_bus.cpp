// test_bus.cpp: what the CAN interface says of itself: bus off, down, error passive, counts, and the way back.
#include "bench.hpp"

namespace gonio::test {
namespace {

struct Bus : testing::Test {
    Bench bench;

    void SetUp() override { ASSERT_NO_FATAL_FAILURE(bench.make_ready()); }
    void move() {
        bench.begin_move(1, 60000, 6.0);
        bench.run(2000 * ms);
        ASSERT_EQ(bench.motion->state, gonio_InstrumentState_STATE_MOVING);
    }
    // Drives and firmware do not hear each other.
    void cut(bool off) {
        bench.echo_lost = off;
        for (Scripted_drive &drive : bench.drives) {
            drive.silent = off;
        }
    }
    std::string refusal(pb_size_t which) {
        std::uint32_t const id = which == gonio_Request_home_tag ? bench.home() : bench.request(which);
        bench.run(10 * ms);
        const gonio_Reply *reply = bench.reply(id);
        EXPECT_TRUE(reply != nullptr && reply->code == gonio_ReplyCode_REPLY_REFUSED);
        return reply == nullptr ? "" : reply->text;
    }
    void way_back() {
        std::uint32_t const clear = bench.request(gonio_Request_clear_fault_tag);
        bench.run(2500 * ms);
        ASSERT_NE(bench.done(clear), nullptr);
        ASSERT_EQ(bench.done(clear)->code, gonio_ReplyCode_REPLY_OK);
        bench.request(gonio_Request_boot_tag);
        bench.run(1000 * ms);
        bench.home();
        bench.run(1000 * ms);
        EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY) << bench.motion->last_fault.sentence;
    }
};

TEST_F(Bus, interface_down_is_a_fault_with_its_own_sentence_and_a_way_back) {
    move();
    bench.bus.state = GN_CAN_DOWN;
    cut(true);
    bench.run(3000 * ms);
    gonio_Fault const fault = bench.only_fault();
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_CAN);
    EXPECT_STREQ(fault.sentence, "the CAN interface is down or gone; position unknown; plug it in and bring it up, "
                                 "then clear the fault, boot and home");
    EXPECT_EQ(refusal(gonio_Request_clear_fault_tag), "the CAN interface is down or gone: plug it in and bring it up");
    bench.bus.state = GN_CAN_ERROR_ACTIVE;
    cut(false);
    way_back();
}

TEST_F(Bus, off_is_a_fault_also_when_the_controller_restarted_before_anyone_looked) {
    move();
    bench.bus.bus_offs = 1;
    bench.bus.error_frames = 33;
    bench.run(3000 * ms);
    EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_CAN);
    EXPECT_STREQ(bench.only_fault().sentence,
                 "CAN bus off after 33 error frames; position unknown; check cable, terminators and bit rate, then "
                 "clear the fault, boot and home");
    way_back();
}

TEST_F(Bus, off_keeps_the_fault_until_it_is_over) {
    move();
    bench.bus.state = GN_CAN_BUS_OFF;
    bench.bus.bus_offs = 1;
    cut(true);
    bench.run(3000 * ms);
    EXPECT_EQ(refusal(gonio_Request_clear_fault_tag), "the CAN bus is off: check cable, terminators and bit rate");
    bench.bus.state = GN_CAN_ERROR_ACTIVE;
    cut(false);
    way_back();
}

TEST(Bus_at_rest, boot_and_home_are_refused_while_the_interface_is_down) {
    Bench bench;
    bench.configure();
    bench.bus.state = GN_CAN_DOWN;
    std::uint32_t const boot = bench.request(gonio_Request_boot_tag);
    bench.run(10 * ms);
    EXPECT_STREQ(bench.reply(boot)->text, "the CAN interface is down or gone: plug it in and bring it up");
    EXPECT_TRUE(bench.all(gonio_Event_fault_tag).empty()); // nothing moves, nothing is lost
    bench.bus.state = GN_CAN_ERROR_ACTIVE;
    std::uint32_t const again = bench.request(gonio_Request_boot_tag);
    bench.run(1000 * ms);
    EXPECT_EQ(bench.done(again)->code, gonio_ReplyCode_REPLY_OK);
}

TEST(Bus_at_rest, bus_off_during_boot_names_the_bus_and_not_a_node) {
    Bench bench;
    bench.configure();
    bench.drives[1].silent = true;
    bench.request(gonio_Request_boot_tag);
    bench.run(50 * ms);
    bench.bus.state = GN_CAN_BUS_OFF;
    bench.bus.bus_offs = 1;
    bench.run(3000 * ms);
    EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_CAN);
}

TEST_F(Bus, error_passive_is_a_warning_once_per_entry_and_no_fault) {
    move();
    auto const warnings = [this] {
        auto const logs = bench.all(gonio_Event_log_tag);
        return std::count_if(logs.begin(), logs.end(), [](const gonio_Event &event) {
            return event.body.log.level == GN_LOG_WARNING &&
                   std::string(event.body.log.text).find("CAN error passive") == 0;
        });
    };
    bench.bus.state = GN_CAN_ERROR_PASSIVE;
    bench.run(100 * ms);
    EXPECT_EQ(warnings(), 1);
    bench.bus.state = GN_CAN_ERROR_WARNING; // flickers, but is not well
    bench.run(10 * ms);
    bench.bus.state = GN_CAN_ERROR_PASSIVE;
    bench.run(10 * ms);
    EXPECT_EQ(warnings(), 1);
    bench.bus.state = GN_CAN_ERROR_ACTIVE;
    bench.run(10 * ms);
    bench.bus.state = GN_CAN_ERROR_PASSIVE;
    bench.run(10 * ms);
    EXPECT_EQ(warnings(), 2);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_MOVING);
}

TEST_F(Bus, counts_and_uncertainty_pass_to_the_stream_side) {
    bench.bus = {GN_CAN_ERROR_ACTIVE, 1, 2, 3, 0, 5, 7.5F};
    bench.run(10 * ms);
    const gn_motion_counters &counters = bench.shared.counters;
    EXPECT_EQ(counters.can_overflow, 1u);
    EXPECT_EQ(counters.can_error_frames, 2u);
    EXPECT_EQ(counters.can_setpoints_dropped, 3u);
    EXPECT_EQ(counters.clock_steps, 5u);
    EXPECT_EQ(bench.shared.sync_stamp_sigma_us, 7.5F);
    EXPECT_EQ(counters.cycles_missed, 0u);
    bench.now_ns += 10 * ms; // asleep over five cycles: this one is late, four are gone
    bench.run(2 * ms);
    EXPECT_EQ(counters.cycles_missed, 4u);
}

} // namespace
} // namespace gonio::test
