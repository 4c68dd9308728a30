// test_commands.cpp: configuration checks, outputs, operator, SDO reads and unknown requests.
#include "bench.hpp"

namespace gonio::test {
namespace {

gonio_Reply configure_axis(Bench &bench, const gonio_AxisConfig &config) {
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_configure_axis_tag;
    r.body.configure_axis = config;
    std::uint32_t const id = bench.request(r);
    bench.run(ms);
    return *bench.reply(id);
}

gonio_Reply configure(Bench &bench, const gonio_Configure &config) {
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_configure_tag;
    r.body.configure = config;
    std::uint32_t const id = bench.request(r);
    bench.run(ms);
    return *bench.reply(id);
}

gonio_Reply read_object(Bench &bench, std::uint32_t node, std::uint32_t index, std::uint32_t subindex) {
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_sdo_read_tag;
    r.body.sdo_read = {node, index, subindex};
    std::uint32_t const id = bench.request(r);
    bench.run(300 * ms);
    return *bench.reply(id);
}

TEST(Commands, invalid_axes_are_refused_by_name_and_change_nothing) {
    Bench bench;
    bench.configure();
    gonio_AxisConfig config = Bench::axis_message(1);
    config.min_counts = config.max_counts;
    EXPECT_STREQ(configure_axis(bench, config).text,
                 "axis 1 (sample roll): min_counts must be less than max_counts, both within 32 bits");
    config = Bench::axis_message(1);
    config.node = 3;
    EXPECT_STREQ(configure_axis(bench, config).text, "axis 1 (sample roll): node 3 is already axis 2");
    config = Bench::axis_message(1);
    config.node = 127;
    EXPECT_STREQ(configure_axis(bench, config).text, "axis 1 (sample roll): node is 127; it must be 1 to 126");
    config = Bench::axis_message(1);
    config.counts_per_deg = 0;
    EXPECT_EQ(configure_axis(bench, config).code, gonio_ReplyCode_REPLY_INVALID);
    config.counts_per_deg = std::nan("");
    EXPECT_EQ(configure_axis(bench, config).code, gonio_ReplyCode_REPLY_INVALID);
    config = Bench::axis_message(0);
    config.axis = 4;
    EXPECT_EQ(configure_axis(bench, config).code, gonio_ReplyCode_REPLY_INVALID);
    EXPECT_EQ(bench.motion->axes[1].config.node, 2u);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_CONFIGURED);
}

// An axis from -5 to 185 degrees with its switch at -5. A wrong sign of counts_per_deg turns limits and switch over,
// and the drive would look for the switch at 185 degrees.
TEST(Commands, wrong_sign_of_an_axis_is_found_by_the_end_at_which_its_switch_lies) {
    Bench bench;
    bench.configure();
    auto const reply = [&](int method, double sign, double switch_deg) {
        gonio_AxisConfig config = Bench::axis_message(0);
        double const limits[] = {-5 * counts_per_deg * sign, 185 * counts_per_deg * sign};
        config.counts_per_deg *= sign;
        config.min_counts = std::min(limits[0], limits[1]);
        config.max_counts = std::max(limits[0], limits[1]);
        config.homing_method = method;
        config.home_offset_counts = static_cast<std::int32_t>(std::lround(switch_deg * counts_per_deg * sign));
        return configure_axis(bench, config);
    };
    for (int const negative_end : {1, 17}) {
        EXPECT_EQ(reply(negative_end, 1, -5).code, gonio_ReplyCode_REPLY_OK);
        EXPECT_EQ(reply(negative_end, -1, -5).code, gonio_ReplyCode_REPLY_INVALID);
        EXPECT_EQ(reply(negative_end, -1, 185).code, gonio_ReplyCode_REPLY_OK); // it does count backwards
    }
    for (int const positive_end : {2, 18}) {
        EXPECT_EQ(reply(positive_end, 1, 185).code, gonio_ReplyCode_REPLY_OK);
        EXPECT_EQ(reply(positive_end, -1, 185).code, gonio_ReplyCode_REPLY_INVALID);
        EXPECT_EQ(reply(positive_end, -1, -5).code, gonio_ReplyCode_REPLY_OK);
    }
    for (int const anywhere : {7, 23, 33, 34, 37}) {
        EXPECT_EQ(reply(anywhere, -1, -5).code, gonio_ReplyCode_REPLY_OK);
    }
    EXPECT_STREQ(reply(1, -1, -5).text,
                 "axis 0 (sample azimuth): homing method 1 goes to the negative end in counts, the switch (5556) is at "
                 "the other: check the sign of counts_per_deg, the method and switch_deg");
}

TEST(Commands, invalid_cycles_are_refused) {
    Bench bench;
    gonio_Configure config = Bench::configure_message();
    config.axis_count = 5;
    EXPECT_STREQ(configure(bench, config).text, "axis_count is 5; it must be 1 to 4");
    config = Bench::configure_message();
    config.sync_window_us = 2001;
    EXPECT_STREQ(configure(bench, config).text, "sync_window_us is 2001; it must be 100 to 2000");
    config = Bench::configure_message();
    config.expiry_ms = 2803;
    EXPECT_STREQ(configure(bench, config).text,
                 "expiry_ms is 2803; a stop may take 2304 and begins after 500 at the earliest: set 2804");
    config = Bench::configure_message();
    config.sync_period_us = 2570;
    EXPECT_EQ(configure(bench, config).code, gonio_ReplyCode_REPLY_INVALID); // 257 * 10^-5 s: not in one byte
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_UNCONFIGURED);
}

TEST(Commands, same_configuration_may_come_again_another_not_while_in_use) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    EXPECT_EQ(configure(bench, Bench::configure_message()).code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(configure_axis(bench, Bench::axis_message(2)).code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
    gonio_AxisConfig other = Bench::axis_message(2);
    other.max_counts -= 1;
    EXPECT_EQ(configure_axis(bench, other).code, gonio_ReplyCode_REPLY_REFUSED);
    gonio_Configure slower = Bench::configure_message();
    slower.sync_period_us = 4000;
    EXPECT_EQ(configure(bench, slower).code, gonio_ReplyCode_REPLY_REFUSED);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
    bench.request(gonio_Request_release_tag);
    bench.run(200 * ms);
    EXPECT_EQ(configure_axis(bench, other).code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_CONFIGURED); // boot again
}

TEST(Commands, zone_with_bad_index_is_refused) {
    Bench bench;
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_configure_zone_tag;
    r.body.configure_zone.index = GN_PATH_ZONES;
    std::uint32_t const bad = bench.request(r);
    r.body.configure_zone.index = 0;
    r.body.configure_zone.half_spaces_count = 1;
    r.body.configure_zone.half_spaces[0].a_count = 4;
    r.body.configure_zone.half_spaces[0].a[0] = 1.0;
    r.body.configure_zone.half_spaces[0].b = -1e6;
    std::uint32_t const good = bench.request(r);
    bench.run(ms);
    EXPECT_EQ(bench.reply(bad)->code, gonio_ReplyCode_REPLY_INVALID);
    EXPECT_EQ(bench.reply(good)->code, gonio_ReplyCode_REPLY_OK);
}

TEST(Commands, outputs_and_operator_are_passed_on_and_recorded) {
    Bench bench;
    bench.set_output(gonio_Output_OUTPUT_LAMP, true);
    EXPECT_TRUE(bench.outputs[GN_OUT_LAMP]);
    EXPECT_EQ(bench.all(gonio_Event_output_tag).size(), 1u);
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_operator_done_tag;
    r.body.operator_done.action = gonio_OperatorAction_OPERATOR_SAMPLE_MOUNTED;
    bench.request(r);
    r.which_body = gonio_Request_set_output_tag;
    r.body.set_output = {gonio_Output_OUTPUT_UNSPECIFIED, true};
    std::uint32_t const none = bench.request(r);
    bench.edge(GN_LINE_DOOR, false);
    bench.run(ms);
    EXPECT_EQ(bench.operator_action, static_cast<std::uint32_t>(gonio_OperatorAction_OPERATOR_SAMPLE_MOUNTED));
    EXPECT_EQ(bench.all(gonio_Event_operator_done_tag).size(), 1u);
    EXPECT_EQ(bench.reply(none)->code, gonio_ReplyCode_REPLY_INVALID);
    r.body.set_output = {gonio_Output_OUTPUT_SHUTTER, true};
    std::uint32_t const open_door = bench.request(r);
    bench.run(ms);
    EXPECT_STREQ(bench.reply(open_door)->text, "the door is open: close it");
    EXPECT_FALSE(bench.outputs[GN_OUT_SHUTTER]);
}

TEST(Commands, sdo_read_answers_with_value_abort_or_time_out) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    gonio_Reply const value = read_object(bench, 3, 0x608F, 1);
    EXPECT_EQ(value.code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(value.body.sdo_value.value, 400000u);
    EXPECT_EQ(value.body.sdo_value.size, 4u);
    EXPECT_STREQ(read_object(bench, 3, 0x2000, 0).text, "node 3, 0x2000:00: object does not exist (0x06020000)");
    EXPECT_EQ(read_object(bench, 9, 0x1000, 0).code, gonio_ReplyCode_REPLY_INVALID);
    bench.meddle = [](gn_can_frame &frame, std::int64_t &) { return frame.id == 0x583; };
    EXPECT_STREQ(read_object(bench, 3, 0x1000, 0).text, "node 3, 0x1000:00: SDO protocol timed out (0x05040000)");
}

TEST(Commands, unknown_request_is_answered) {
    Bench bench;
    std::uint32_t const id = bench.request(0);
    bench.run(ms);
    EXPECT_EQ(bench.reply(id)->code, gonio_ReplyCode_REPLY_INVALID);
}

} // namespace
} // namespace gonio::test
