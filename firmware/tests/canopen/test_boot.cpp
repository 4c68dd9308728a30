// test_boot.cpp: boot of the three drive personalities, and of drives that cannot be used: one sentence names the
// object.
#include "bench.hpp"

namespace gonio::test {
namespace {

std::string boot_sentence(Bench &bench) {
    bench.configure();
    std::uint32_t const id = bench.request(gonio_Request_boot_tag);
    bench.run(3000 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_FAULT);
    const gonio_OperationDone *done = bench.done(id);
    EXPECT_TRUE(done != nullptr && done->code == gonio_ReplyCode_REPLY_FAULT);
    gonio_Fault const fault = bench.only_fault();
    EXPECT_STREQ(done != nullptr ? done->text : "", fault.sentence);
    return fault.sentence;
}

TEST(Boot, full_personality_gets_every_object) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    auto value = [&](int node, int index, int sub) { return bench.drives[node - 1].objects.at({index, sub}).value; };
    EXPECT_EQ(value(2, 0x1017, 0), 100u);
    EXPECT_EQ(value(2, 0x1016, 1), 127u << 16 | 300u);
    EXPECT_EQ(value(2, 0x1400, 1), 0x202u);
    EXPECT_EQ(value(2, 0x1400, 2), 1u);
    EXPECT_EQ(value(2, 0x1400, 5), 6u); // three SYNCs of 2 ms
    EXPECT_EQ(value(2, 0x1600, 1), 0x60400010u);
    EXPECT_EQ(value(2, 0x1600, 2), 0x607A0020u);
    EXPECT_EQ(value(2, 0x1800, 1), 0x182u);
    EXPECT_EQ(value(2, 0x1A00, 2), 0x60640020u);
    EXPECT_EQ(value(2, 0x1007, 0), 1500u);
    EXPECT_EQ(value(2, 0x1019, 0), 240u);
    EXPECT_EQ(value(2, 0x6007, 0), 3u);
    EXPECT_EQ(value(2, 0x6085, 0), 222222u);
    EXPECT_EQ(static_cast<std::int32_t>(value(2, 0x607D, 1)), -222222);
    EXPECT_EQ(value(2, 0x607D, 2), 222222u);
    EXPECT_EQ(value(2, 0x6065, 0), 556u);
    EXPECT_EQ(value(2, 0x6066, 0), 20u);
    EXPECT_EQ(value(2, 0x60C2, 1), 2u);
    EXPECT_EQ(value(2, 0x60C2, 2), 0xFDu); // 2 * 10^-3 s
    EXPECT_EQ(value(2, 0x60FE, 2), 0u);
    EXPECT_EQ(value(4, 0x60FE, 2), 1u); // the axis with a brake
    std::uint32_t const id = bench.request(gonio_Request_get_info_tag);
    bench.run(ms);
    const gonio_Info &info = bench.reply(id)->body.info;
    EXPECT_EQ(info.nodes_count, 4);
    EXPECT_EQ(info.nodes[2].device_type, 0x00040192u);
    EXPECT_EQ(info.nodes[2].vendor, 0x1003u);
    EXPECT_EQ(info.nodes[2].serial, 0x4003u);
    EXPECT_STREQ(info.nodes[2].notes, "");
}

TEST(Boot, pdos_are_switched_off_while_they_are_mapped) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    std::vector<std::string> to_node_1;
    for (const gn_can_frame &frame : bench.sent) {
        if (frame.id == 0x601 && (frame.data[0] & 0xE0) == 0x20 && frame.data[2] >= 0x14 && frame.data[2] <= 0x16) {
            to_node_1.push_back(hex(frame));
        }
    }
    EXPECT_EQ(to_node_1,
              (std::vector<std::string>{"601#2300140101020080", "601#2F00160000000000", "601#2300160110004060",
                                        "601#2300160220007A60", "601#2F00160002000000", "601#2F00140201000000",
                                        "601#2B00140506000000", "601#2300140101020000"}));
}

TEST(Boot, plain_personality_is_accepted_with_notes) {
    for (auto [units, exponent] : {std::pair{2, -3}, std::pair{20, -4}, std::pair{200, -5}}) {
        Bench bench;
        bench.drives[1].make_plain(static_cast<std::uint32_t>(units), exponent);
        ASSERT_NO_FATAL_FAILURE(bench.boot());
        EXPECT_STREQ(bench.motion->axes[1].info.notes, "no 0x1029, no 0x6007, 0x60C2 read only");
        EXPECT_STREQ(bench.motion->axes[0].info.notes, "");
    }
}

TEST(Boot, plain_personality_of_another_period_is_refused) {
    for (auto [units, exponent] : {std::pair{1, -3}, std::pair{2, -2}, std::pair{200, -7}, std::pair{2, 100}}) {
        Bench bench;
        bench.drives[1].make_plain(static_cast<std::uint32_t>(units), exponent);
        std::string const sentence = boot_sentence(bench);
        EXPECT_NE(sentence.find("sample roll (node 2): 0x60C2 (interpolation period) is read only"), std::string::npos)
            << sentence;
        EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_READ_BACK);
    }
}

TEST(Boot, fixed_maps_are_read_and_used) {
    for (std::uint32_t const refusal : {0x06010002u, 0x08000022u}) {
        Bench bench;
        bench.drives[2].make_fixed({0x60400010, 0x607A0020, 0x60600008}, {0x60410010, 0x60640020, 0x60610008}, refusal);
        bench.drives[3].make_fixed({0x60600008, 0x607A0020, 0x60400010}, {0x60640020, 0x60610008, 0x60410010}, refusal);
        ASSERT_NO_FATAL_FAILURE(bench.make_ready());
        EXPECT_STREQ(bench.motion->axes[2].info.notes, "fixed map 0x1600, fixed map 0x1A00");
        EXPECT_EQ(bench.drives[2].objects.at({0x6065, 0}).value, 556u);
        EXPECT_EQ(bench.motion->axes[3].measured_counts, bench.drives[3].position);
    }
}

TEST(Boot, fixed_map_without_the_target_names_it) {
    Bench bench;
    bench.drives[2].make_fixed({0x60400010, 0x60FF0020}, {0x60410010, 0x60640020}, 0x06010002);
    std::string const sentence = boot_sentence(bench);
    EXPECT_EQ(sentence, "arm azimuth (node 3): its fixed PDO map 0x1600 lacks 0x607A (target position); change the map "
                        "with the maker's tool, or change the drive");
    EXPECT_EQ(bench.only_fault().index, 0x1600u);
}

// 300 ms of heartbeat time-out at v, then v^2 / 2a at 200 deg/s2: 3.2456 deg/s goes 0.97368 + 0.02633 = 1 degree.
TEST(Boot, missing_rpdo_deadline_is_noted_and_limits_the_speed) {
    Bench bench;
    bench.drives[0].objects.erase({0x1400, 5});
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    EXPECT_STREQ(bench.motion->axes[0].info.notes, "no 0x1400:05, at most 3.25 deg/s");
    EXPECT_STREQ(bench.motion->axes[1].info.notes, "");
    EXPECT_NEAR(bench.motion->path.limits[0].max_velocity_counts_per_s, 3.24555 * counts_per_deg, 0.1);
    EXPECT_EQ(bench.motion->path.limits[1].max_velocity_counts_per_s, Bench::axis_message(1).max_velocity_counts_per_s);
    bench.begin_move(1, 10 * counts_per_deg, 5.0); // 15 / 8 of the mean: 3.75 deg/s at the middle
    bench.run(100 * ms);
    auto const logs = bench.all(gonio_Event_log_tag);
    ASSERT_EQ(logs.size(), 1u);
    EXPECT_STREQ(logs[0].body.log.text,
                 "axis 1, knot 1: velocity 4167 counts/s is over the limit of 3606: its drive has no 0x1400:05 (see "
                 "info): lower max_velocity_deg_per_s, or change the drive");
    EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_STOPPED);
    bench.begin_move(2, 10 * counts_per_deg, 6.0); // 3.125 deg/s
    bench.run(7000 * ms);
    EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_FINISHED);
}

TEST(Boot, units_that_are_encoder_counts_are_taken_with_and_without_a_gear) {
    struct {
        std::uint32_t motor, shaft, feed, feed_shaft, encoder;
    } const cases[] = {
        {1, 1, 400000, 1, 400000}, {1, 1, 800000, 2, 400000}, {100, 1, 400000, 1, 4000}, {50, 2, 400000, 1, 16000}};
    for (const auto &c : cases) {
        Bench bench;
        auto &objects = bench.drives[1].objects;
        objects[{0x6091, 1}] = {c.motor, 4};
        objects[{0x6091, 2}] = {c.shaft, 4};
        objects[{0x6092, 1}] = {c.feed, 4};
        objects[{0x6092, 2}] = {c.feed_shaft, 4};
        objects[{0x60A9, 0}] = {0x00B50300, 4};
        objects[{0x608F, 1}].value = c.encoder;
        bench.configure();
        gonio_Request r = gonio_Request_init_zero;
        r.which_body = gonio_Request_configure_axis_tag;
        r.body.configure_axis = Bench::axis_message(1);
        r.body.configure_axis.counts_per_turn = c.encoder;
        bench.request(r);
        bench.request(gonio_Request_boot_tag);
        bench.run(1000 * ms);
        EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_UNHOMED) << bench.motion->last_fault.sentence;
    }
}

TEST(Boot, units_that_are_no_encoder_counts_are_refused) {
    Bench feed;
    feed.drives[1].objects[{0x6092, 1}] = {36000, 4}; // hundredths of a degree
    feed.drives[1].objects[{0x6092, 2}] = {1, 4};
    EXPECT_EQ(boot_sentence(feed),
              "sample roll (node 2): 0x6092 (feed) makes 36000 units of a shaft revolution that has 400000 encoder "
              "counts; set 0x6092 so that positions are encoder counts");
    EXPECT_EQ(feed.only_fault().code, gonio_FaultCode_FAULT_WRONG_DEVICE);
    EXPECT_EQ(feed.only_fault().index, 0x6092u);
    Bench gear;
    gear.drives[1].objects[{0x6091, 1}] = {2, 4};
    gear.drives[1].objects[{0x6091, 2}] = {1, 4};
    gear.drives[1].objects[{0x6092, 1}] = {800000, 4};
    gear.drives[1].objects[{0x6092, 2}] = {1, 4};
    EXPECT_EQ(boot_sentence(gear),
              "sample roll (node 2): 0x6091 and 0x6092 make 800000 counts per turn, counts_per_deg makes 400000; check "
              "0x6091 and counts_per_deg");
    Bench nothing;
    nothing.drives[1].objects[{0x6092, 1}] = {400000, 4};
    nothing.drives[1].objects[{0x6092, 2}] = {0, 4};
    EXPECT_NE(boot_sentence(nothing).find("0x6092 (feed)"), std::string::npos);
    Bench rpm;
    rpm.drives[1].objects[{0x60A9, 0}] = {0x00B44700, 4}; // revolutions per minute
    EXPECT_EQ(boot_sentence(rpm), "sample roll (node 2): 0x60A9 (velocity unit) is 0x00B44700, not counts per second; "
                                  "set it to 0x00B50300 with the maker's tool");
}

TEST(Boot, read_only_transmission_type_must_be_the_one_that_is_needed) {
    Bench fitting;
    fitting.drives[0].objects[{0x1400, 2}] = {1, 1, Access::read_only};
    fitting.drives[0].objects[{0x1400, 1}] = {0x201, 4, Access::read_only};
    ASSERT_NO_FATAL_FAILURE(fitting.boot());
    Bench other;
    other.drives[0].objects[{0x1400, 2}] = {255, 1, Access::read_only};
    EXPECT_EQ(boot_sentence(other), "sample azimuth (node 1): 0x1400:02 (RPDO1 transmission type) is to be 0x1 and "
                                    "reads back 0xFF; the drive limits or ignores it: check the axis's limits");
}

TEST(Boot, drive_that_starts_without_tpdo_is_named) {
    Bench bench;
    bench.meddle = [](gn_can_frame &frame, std::int64_t &) { return frame.id == 0x183; };
    EXPECT_EQ(boot_sentence(bench),
              "arm azimuth (node 3): operational 2000 ms after its start, without TPDO1 (0x1800); "
              "check 0x1800, 0x1A00 and the SYNC");
}

TEST(Boot, value_that_does_not_stick_is_a_read_back_fault) {
    Bench bench;
    bench.drives[2].objects[{0x6065, 0}].sticks = false;
    EXPECT_EQ(boot_sentence(bench),
              "arm azimuth (node 3): 0x6065 (following error window) is to be 0x22C and reads back "
              "0xFFFFFFFF; the drive limits or ignores it: check the axis's limits");
    gonio_Fault const fault = bench.only_fault();
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_READ_BACK);
    EXPECT_EQ(fault.index, 0x6065u);
    EXPECT_EQ(fault.node, 3u);
    EXPECT_EQ(fault.axis, 2u);
}

TEST(Boot, refused_required_object_is_named_with_the_abort_in_words) {
    Bench bench;
    bench.drives[1].objects.erase({0x6085, 0});
    EXPECT_EQ(boot_sentence(bench),
              "sample roll (node 2): writing of 0x6085 (quick stop deceleration) aborted: object does "
              "not exist (0x06020000); set the axis up for this drive, or change the drive");
    EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_SDO_ABORT);
}

TEST(Boot, silent_node_is_missing) {
    Bench bench;
    bench.drives[2].silent = true;
    EXPECT_EQ(boot_sentence(bench),
              "arm azimuth (node 3): no boot-up message within 2000 ms of its reset; check its power, "
              "cable, node id, bit rate");
    EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_NODE_MISSING);
}

TEST(Boot, node_that_stops_answering_times_out) {
    Bench bench;
    bench.meddle = [](gn_can_frame &frame, std::int64_t &) {
        return frame.id == 0x581 && frame.data[1] == 0x65 && frame.data[2] == 0x60;
    };
    EXPECT_EQ(boot_sentence(bench),
              "sample azimuth (node 1): no answer to 0x6065 (following error window) within 200 ms; "
              "check its cable, or raise sdo_timeout_ms if the drive is slow");
    EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_SDO_TIMEOUT);
}

TEST(Boot, wrong_device_and_wrong_encoder_are_refused) {
    Bench io_module;
    io_module.drives[0].objects[{0x1000, 0}].value = 0x000F0191;
    EXPECT_NE(boot_sentence(io_module).find("0x1000 (device type) is 0x000F0191, not a CiA 402 drive"),
              std::string::npos);
    EXPECT_EQ(io_module.only_fault().code, gonio_FaultCode_FAULT_WRONG_DEVICE);
    Bench encoder;
    encoder.drives[0].objects[{0x608F, 1}].value = 40000;
    EXPECT_NE(
        boot_sentence(encoder).find("0x608F:01 (encoder increments) is 40000, the axis configuration says 400000"),
        std::string::npos);
}

TEST(Boot, is_refused_before_the_configuration_is_complete) {
    Bench bench;
    std::uint32_t const early = bench.request(gonio_Request_boot_tag);
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_configure_tag;
    r.body.configure = Bench::configure_message();
    bench.request(r);
    std::uint32_t const half = bench.request(gonio_Request_boot_tag);
    bench.run(10 * ms);
    EXPECT_EQ(bench.reply(early)->code, gonio_ReplyCode_REPLY_REFUSED);
    EXPECT_STREQ(bench.reply(early)->text,
                 "Configure was not received: send Configure and every AxisConfig before Boot");
    EXPECT_STREQ(bench.reply(half)->text,
                 "AxisConfig of axis 0 was not received: send Configure and every AxisConfig before Boot");
}

TEST(Boot, works_again_after_a_fault_was_cleared) {
    Bench bench;
    bench.drives[2].silent = true;
    boot_sentence(bench);
    bench.drives[2].silent = false;
    std::uint32_t const clear = bench.request(gonio_Request_clear_fault_tag);
    bench.run(100 * ms);
    ASSERT_NE(bench.done(clear), nullptr);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_CONFIGURED);
    bench.request(gonio_Request_boot_tag);
    bench.run(1000 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_UNHOMED);
}

} // namespace
} // namespace gonio::test
