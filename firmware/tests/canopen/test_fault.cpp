// test_fault.cpp: every fault: its sentence, the safe state, and the way back.
#include "bench.hpp"

namespace gonio::test {
namespace {

// All axes ready, axis 0 half-way along a move, shutter open.
struct Moving : testing::Test {
    Bench bench;

    void SetUp() override {
        ASSERT_NO_FATAL_FAILURE(bench.make_ready());
        bench.set_output(gonio_Output_OUTPUT_SHUTTER, true);
        bench.begin_move(1, 60000, 6.0);
        bench.run(3000 * ms);
        ASSERT_EQ(bench.motion->state, gonio_InstrumentState_STATE_MOVING);
    }
    gonio_Fault safe_after(std::int64_t duration_ns) {
        bench.run(duration_ns);
        EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_FAULT);
        EXPECT_FALSE(bench.outputs[GN_OUT_SHUTTER]);
        EXPECT_EQ(known_mask(bench), 0u);
        EXPECT_EQ(bench.motion->path.state, GN_PATH_IDLE);
        EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_FAULT);
        gonio_Fault const fault = bench.only_fault();
        EXPECT_STREQ(bench.motion->last_fault.sentence, fault.sentence);
        return fault;
    }
    static bool says(const gonio_Fault &fault, const std::string &words) {
        return std::string(fault.sentence).find(words) != std::string::npos;
    }
};

TEST_F(Moving, blocked_axis_emcy_names_commanded_and_measured_position) {
    bench.drives[0].blocked = true;
    bench.run(20 * ms);
    bench.arrive(bench.drives[0].emergency(0x8611));
    gonio_Fault const fault = safe_after(2000 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_FOLLOWING_ERROR);
    EXPECT_EQ(fault.index, 0x6065u);
    EXPECT_GT(fault.commanded_counts, fault.measured_counts);
    char expected[240];
    std::snprintf(
        expected, sizeof expected,
        "sample azimuth (node 1): EMCY 0x8611 following error (0x6065); commanded %d counts (%.3f deg), measured "
        "%d (%.3f deg); free the axis, or lower speed and acceleration",
        fault.commanded_counts, fault.commanded_counts / counts_per_deg, fault.measured_counts,
        fault.measured_counts / counts_per_deg);
    EXPECT_STREQ(fault.sentence, expected);
    EXPECT_EQ(bench.drives[0].status & 0x6F, 0x07); // quick stop
    EXPECT_EQ(bench.drives[1].status & 0x6F, 0x27); // the others hold
}

TEST_F(Moving, following_error_bit_is_a_fault_without_an_emcy) {
    bench.drives[0].blocked = true;
    gonio_Fault const fault = safe_after(2000 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_FOLLOWING_ERROR);
    EXPECT_GT(fault.commanded_counts - fault.measured_counts, 556);
    EXPECT_TRUE(says(fault, "following error beyond 0x6065 (556 counts)"));
}

TEST_F(Moving, emcy_of_another_axis_holds_this_one_on_its_path) {
    bench.arrive(bench.drives[2].emergency(0x7305));
    std::int32_t const before = bench.drives[0].position;
    gonio_Fault const fault = safe_after(3000 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_EMERGENCY);
    EXPECT_TRUE(says(fault, "arm azimuth (node 3): EMCY 0x7305 encoder 1 error (0x603F)")) << fault.sentence;
    EXPECT_GT(bench.drives[0].position, before + 1000); // a controlled stop takes its way
    EXPECT_EQ(bench.drives[0].status & 0x6F, 0x27);
    EXPECT_EQ(bench.drives[2].status & 0x6F, 0x07);
}

TEST_F(Moving, error_reset_emcy_is_no_fault) {
    bench.arrive(bench.drives[2].emergency(0x0000));
    bench.run(100 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_MOVING);
}

TEST_F(Moving, silent_node_is_lost) {
    bench.drives[1].silent = true;
    gonio_Fault const fault = safe_after(3000 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_NODE_LOST);
    EXPECT_EQ(fault.node, 2u);
    EXPECT_EQ(fault.index, 0x1017u);
    EXPECT_TRUE(says(fault, "sample roll (node 2): no heartbeat (0x1017) for 300 ms"));
}

TEST_F(Moving, unexpected_boot_up_is_a_reset_node) {
    bench.arrive(frame_of(0x703, {0x00}));
    gonio_Fault const fault = safe_after(3000 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_NODE_RESET);
    EXPECT_TRUE(says(fault, "arm azimuth (node 3): unexpected boot-up message"));
}

TEST_F(Moving, node_that_leaves_operational_is_a_fault) {
    bench.drives[3].operational = false;
    gonio_Fault const fault = safe_after(3000 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_DRIVE_STATE);
    EXPECT_TRUE(says(fault, "arm elevation (node 4): became pre-operational by itself"));
}

TEST_F(Moving, drive_that_leaves_operation_enabled_is_a_fault) {
    bench.drives[2].status = 0x0008;
    gonio_Fault const fault = safe_after(3000 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_DRIVE_STATE);
    EXPECT_EQ(fault.index, 0x6041u);
    EXPECT_TRUE(says(fault, "arm azimuth (node 3): left operation enabled, 0x6041 (statusword) 0x0008: fault"));
    EXPECT_EQ(bench.drives[2].status, 0x0008); // never reset behind the operator's back
}

TEST_F(Moving, lost_echoes_and_bus_off_are_can_faults) {
    bench.echo_lost = true;
    gonio_Fault const fault = safe_after(3000 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_CAN);
    EXPECT_TRUE(says(fault, "5 SYNCs (0x080) in a row did not come back from the bus"));
    EXPECT_GE(bench.shared.counters.sync_echoes_lost, 5u);
}

TEST_F(Moving, four_lost_echoes_are_no_fault) {
    bench.echo_lost = true;
    bench.run(8 * ms);
    bench.echo_lost = false;
    bench.run(100 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_MOVING);
    EXPECT_EQ(bench.shared.counters.sync_echoes_lost, 4u);
}

TEST_F(Moving, bus_off_is_a_fault) {
    bench.bus.state = GN_CAN_BUS_OFF;
    bench.bus.error_frames = 7;
    gonio_Fault const fault = safe_after(3000 * ms);
    EXPECT_TRUE(says(fault, "CAN bus off after 7 error frames"));
}

TEST_F(Moving, door_stops_on_the_path) {
    bench.edge(GN_LINE_DOOR, false);
    gonio_Fault const fault = safe_after(3000 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_DOOR);
    EXPECT_EQ(fault.axis, 255u);
    EXPECT_STREQ(fault.sentence,
                 "the door was opened while drives were enabled; position unknown; make it safe, then clear "
                 "the fault and home");
    EXPECT_EQ(bench.drives[0].status & 0x6F, 0x27);
    EXPECT_EQ(bench.drives[0].position, bench.motion->axes[0].target_counts);
}

TEST_F(Moving, sto_and_emergency_stop_end_the_path_at_once) {
    for (Scripted_drive &drive : bench.drives) {
        drive.torque = false;
    }
    bench.edge(GN_LINE_STO, false);
    gonio_Fault const fault = safe_after(10 * ms);
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_STO);
    bench.run(1000 * ms);
    EXPECT_EQ(bench.all(gonio_Event_fault_tag).size(), 1u);
    std::uint32_t const id = bench.request(gonio_Request_clear_fault_tag);
    bench.run(10 * ms);
    EXPECT_STREQ(bench.reply(id)->text, "STO is active: close the safety circuit");
}

TEST_F(Moving, emergency_stop_is_named) {
    bench.edge(GN_LINE_EMERGENCY_STOP, false);
    EXPECT_EQ(safe_after(10 * ms).code, gonio_FaultCode_FAULT_EMERGENCY_STOP);
}

TEST_F(Moving, second_fault_is_logged_not_reported_again) {
    bench.arrive(bench.drives[2].emergency(0x7305));
    bench.arrive(bench.drives[1].emergency(0x4210));
    safe_after(3000 * ms);
    auto const logs = bench.all(gonio_Event_log_tag);
    ASSERT_EQ(logs.size(), 1u);
    EXPECT_NE(std::string(logs[0].body.log.text).find("sample roll (node 2): EMCY 0x4210 drive too hot"),
              std::string::npos);
}

TEST_F(Moving, way_back_is_clear_boot_home) {
    bench.drives[2].status = 0x0008;
    safe_after(3000 * ms);
    gonio_Request open = gonio_Request_init_zero;
    open.which_body = gonio_Request_set_output_tag;
    open.body.set_output = {gonio_Output_OUTPUT_SHUTTER, true};
    std::uint32_t const shutter = bench.request(open);
    std::uint32_t const early = bench.home();
    bench.run(10 * ms);
    EXPECT_EQ(bench.reply(shutter)->code, gonio_ReplyCode_REPLY_REFUSED);
    EXPECT_EQ(bench.reply(early)->code, gonio_ReplyCode_REPLY_REFUSED);
    std::uint32_t const clear = bench.request(gonio_Request_clear_fault_tag);
    bench.run(200 * ms);
    ASSERT_NE(bench.done(clear), nullptr);
    EXPECT_EQ(bench.done(clear)->code, gonio_ReplyCode_REPLY_OK);
    for (const Scripted_drive &drive : bench.drives) {
        EXPECT_EQ(drive.status & 0x4F, 0x40);
    }
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_CONFIGURED);
    bench.request(gonio_Request_boot_tag);
    bench.run(1000 * ms);
    bench.home();
    bench.run(1000 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
}

TEST_F(Moving, fault_that_stays_is_told_by_clear_fault) {
    bench.drives[2].torque = false; // its status falls to fault and cannot be reset
    safe_after(3000 * ms);
    std::uint32_t const clear = bench.request(gonio_Request_clear_fault_tag);
    bench.run(2500 * ms);
    EXPECT_EQ(bench.done(clear)->code, gonio_ReplyCode_REPLY_FAULT);
    EXPECT_STREQ(bench.done(clear)->text,
                 "arm azimuth (node 3) does not release, 0x6041 (statusword) 0x0008: fault; read 0x603F");
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_FAULT);
}

TEST(Release, goes_down_state_by_state_and_the_gravity_axis_by_quick_stop) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    for (Scripted_drive &drive : bench.drives) {
        drive.controlwords.clear();
    }
    std::uint32_t const id = bench.request(gonio_Request_release_tag);
    bench.run(200 * ms);
    ASSERT_NE(bench.done(id), nullptr);
    EXPECT_EQ(bench.done(id)->code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(bench.drives[0].controlwords, (std::vector<std::uint16_t>{0x07, 0x06, 0x00}));
    EXPECT_EQ(bench.drives[3].controlwords, (std::vector<std::uint16_t>{0x02, 0x00}));
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_UNHOMED);
    bench.edge(GN_LINE_DOOR, false); // nothing is enabled: no fault
    bench.run(10 * ms);
    EXPECT_TRUE(bench.all(gonio_Event_fault_tag).empty());
}

} // namespace
} // namespace gonio::test
