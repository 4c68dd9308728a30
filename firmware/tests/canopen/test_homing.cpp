// test_homing.cpp: homing by groups, its time-out, its error, and being stopped.
#include "bench.hpp"

namespace gonio::test {
namespace {

TEST(Homing, leaves_the_axes_enabled_in_csp_where_they_stand) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    EXPECT_TRUE(bench.poses.back().flags & GN_POSE_POSITION_UNKNOWN);
    std::uint32_t const id = bench.home();
    bench.run(1000 * ms);
    EXPECT_EQ(bench.reply(id)->code, gonio_ReplyCode_REPLY_ACCEPTED);
    ASSERT_NE(bench.done(id), nullptr);
    EXPECT_EQ(bench.done(id)->code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
    for (const Scripted_drive &drive : bench.drives) {
        EXPECT_EQ(drive.position, 0);
        EXPECT_EQ(drive.objects.at({0x6061, 0}).value, 8u);
        EXPECT_EQ(drive.status & 0x6F, 0x27);
        // Shutdown, switch on, enable operation, homing start, back to enable operation.
        EXPECT_EQ(drive.controlwords, (std::vector<std::uint16_t>{0x06, 0x07, 0x0F, 0x1F, 0x0F}));
    }
    EXPECT_EQ(bench.all(gonio_Event_status_tag).back().body.status.position_known_mask, 0xFu);
    EXPECT_EQ(+bench.poses.back().flags, 0);
}

TEST(Homing, follows_the_homing_order) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    bench.home();
    std::vector<std::uint32_t> began;
    for (int i = 0; i < 500; i++) {
        bench.run(2 * ms);
        for (const Scripted_drive &drive : bench.drives) {
            if (drive.homing_cycles == 1) {
                began.push_back(drive.node);
            }
        }
    }
    ASSERT_GE(began.size(), 4u);
    EXPECT_EQ(began[0], 4u);                                                           // order 0: the arm's elevation
    EXPECT_EQ(began[1], 3u);                                                           // order 1
    EXPECT_TRUE((began[2] == 1 && began[3] == 2) || (began[2] == 2 && began[3] == 1)); // order 2, together
}

TEST(Homing, of_one_axis_leaves_the_instrument_unhomed) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    bench.home(0x4);
    bench.run(500 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_UNHOMED);
    EXPECT_EQ(known_mask(bench), 0x4u);
    bench.home(0xB);
    bench.run(1000 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
}

TEST(Homing, does_not_take_an_old_attained_for_its_own) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    int const before = bench.drives[0].homing_cycles;
    bench.drives[0].position = 700;
    bench.home();
    bench.run(1000 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
    EXPECT_EQ(bench.drives[0].position, 0);
    EXPECT_GE(before, 20);
}

TEST(Homing, that_never_ends_times_out) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    bench.drives[2].homing_stalls = true;
    std::uint32_t const id = bench.home();
    bench.run(4000 * ms);
    EXPECT_EQ(bench.done(id)->code, gonio_ReplyCode_REPLY_FAULT);
    gonio_Fault const fault = bench.only_fault();
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_HOMING);
    EXPECT_EQ(fault.index, 0x6098u);
    EXPECT_NE(
        std::string(fault.sentence).find("arm azimuth (node 3): homing (0x6098 method 1) not finished within 2000 ms"),
        std::string::npos)
        << fault.sentence;
    EXPECT_NE(
        std::string(fault.sentence).find("if it went the wrong way check its wiring and sign, else switch and 0x6099"),
        std::string::npos)
        << fault.sentence;
    EXPECT_EQ(bench.drives[2].status & 0x6F, 0x07); // quick stop active
}

TEST(Homing, error_of_the_drive_is_a_fault) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    bench.drives[3].homing_fails = true;
    bench.home();
    bench.run(1000 * ms);
    gonio_Fault const fault = bench.only_fault();
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_HOMING);
    EXPECT_EQ(fault.node, 4u);
    EXPECT_NE(std::string(fault.sentence).find("homing error, 0x6041 (statusword) 0x2027, method 1"), std::string::npos)
        << fault.sentence;
}

TEST(Homing, mode_that_is_not_taken_is_a_fault_before_anything_moves) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    bench.drives[3].objects[{0x6060, 0}].sticks = false;
    bench.home();
    bench.run(3000 * ms);
    gonio_Fault const fault = bench.only_fault();
    EXPECT_EQ(fault.index, 0x6061u);
    EXPECT_TRUE(bench.drives[3].controlwords.empty());
}

TEST(Homing, each_way_in_which_its_sdo_transfers_can_fail_is_named) {
    struct {
        int index;
        bool silent;
        gonio_FaultCode code;
        const char *words;
    } const cases[] = {
        {0x6060, false, gonio_FaultCode_FAULT_SDO_ABORT, "writing of 0x6060 (mode) aborted: object is read only"},
        {0x6060, true, gonio_FaultCode_FAULT_SDO_TIMEOUT, "no answer to 0x6060 (mode) within 200 ms"},
        {0x6061, false, gonio_FaultCode_FAULT_SDO_ABORT,
         "reading of 0x6061 (mode display) aborted: object does not exist"},
        {0x6061, true, gonio_FaultCode_FAULT_SDO_TIMEOUT, "no answer to 0x6061 (mode display) within 200 ms"},
    };
    for (const auto &c : cases) {
        Bench bench;
        ASSERT_NO_FATAL_FAILURE(bench.boot());
        bench.meddle = [&](gn_can_frame &frame, std::int64_t &) {
            bool const meant = frame.id == 0x584 && frame.data[1] == (c.index & 0xFF) && frame.data[2] == 0x60;
            if (meant && !c.silent) { // an abort in its place
                std::uint8_t const code[] = {static_cast<std::uint8_t>(c.index == 0x6060 ? 2 : 0), 0,
                                             static_cast<std::uint8_t>(c.index == 0x6060 ? 1 : 2), 6};
                frame.data[0] = 0x80;
                std::copy(std::begin(code), std::end(code), frame.data + 4);
            }
            return meant && c.silent;
        };
        bench.home();
        bench.run(1000 * ms);
        gonio_Fault const fault = bench.only_fault();
        EXPECT_EQ(fault.code, c.code);
        EXPECT_NE(std::string(fault.sentence).find(c.words), std::string::npos) << fault.sentence;
    }
}

TEST(Homing, drive_without_torque_is_not_enabled) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    bench.drives[3].torque = false;
    bench.drives[3].status = 0x0008;
    bench.home();
    bench.run(3000 * ms);
    EXPECT_NE(std::string(bench.only_fault().sentence).find("not enabled, 0x6041 (statusword) 0x0008: fault"),
              std::string::npos);
}

TEST(Homing, is_halted_by_stop_and_can_be_done_again) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    bench.drives[3].homing_stalls = true;
    std::uint32_t const id = bench.home();
    bench.run(200 * ms);
    bench.shared.stop_requested++;
    bench.run(100 * ms);
    EXPECT_EQ(bench.done(id)->code, gonio_ReplyCode_REPLY_REFUSED);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_UNHOMED);
    EXPECT_EQ(bench.drives[3].controlword, 0x010F); // enabled, halted
    bench.drives[3].homing_stalls = false;
    bench.home();
    bench.run(1000 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
}

TEST(Homing, is_refused_with_the_door_open_or_before_boot) {
    Bench bench;
    std::uint32_t const early = bench.home();
    bench.run(ms);
    EXPECT_EQ(bench.reply(early)->code, gonio_ReplyCode_REPLY_REFUSED);
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    bench.edge(GN_LINE_DOOR, false);
    bench.run(ms);
    std::uint32_t const open = bench.home();
    bench.run(ms);
    EXPECT_STREQ(bench.reply(open)->text, "the door is open: close it");
    std::uint32_t const nobody = bench.home(0x10);
    bench.edge(GN_LINE_DOOR, true);
    bench.run(ms);
    EXPECT_EQ(bench.reply(nobody)->code, gonio_ReplyCode_REPLY_INVALID);
}

} // namespace
} // namespace gonio::test
