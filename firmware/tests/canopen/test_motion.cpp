// test_motion.cpp: the cycle, paths, controlled stop and expiry, on scripted drives and the real path code.
#include "bench.hpp"

namespace gonio::test {
namespace {

TEST(Motion, cycle_is_one_sync_then_four_rpdos) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    bench.sent.clear();
    bench.run(200 * ms);
    std::string order;
    std::size_t syncs = 0;
    for (const gn_can_frame &frame : bench.sent) {
        if (frame.id == 0x080) {
            EXPECT_TRUE(order.empty() || order == "1234") << order;
            order.clear();
            syncs++;
        } else if (frame.id >= 0x201 && frame.id <= 0x204) {
            order += static_cast<char>('0' + frame.id - 0x200);
        }
    }
    EXPECT_EQ(syncs, 100u);
}

TEST(Motion, path_is_followed_to_its_end) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    std::uint32_t const id = bench.begin_move(7, 10000, 2.0);
    bench.run(2500 * ms);
    EXPECT_EQ(bench.reply(id)->code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(bench.drives[0].position, 10000);
    auto const paths = bench.all(gonio_Event_path_tag);
    ASSERT_EQ(paths.size(), 2u);
    EXPECT_EQ(paths[0].body.path.end, gonio_PathEnd_PATH_RUNNING);
    EXPECT_EQ(paths[1].body.path.end, gonio_PathEnd_PATH_FINISHED);
    EXPECT_EQ(paths[1].body.path.path_id, 7u);
    EXPECT_EQ(paths[1].body.path.path_time_ns, 2'000'000'000);
    EXPECT_NEAR(static_cast<double>(paths[1].time_ns - paths[0].time_ns), 2e9, 4e6);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
}

TEST(Motion, poses_are_the_minimum_jerk_curve_at_the_sync_times) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    bench.poses.clear();
    bench.begin_move(7, 10000, 2.0);
    bench.run(2500 * ms);
    // Rest to rest with zero acceleration: x = d (10 u^3 - 15 u^4 + 6 u^5). The first SYNC at which a target takes
    // effect is found by the fit of one delay; it must be a whole number of cycles.
    auto const begin =
        std::find_if(bench.poses.begin(), bench.poses.end(), [](const gn_pose &p) { return p.position_counts[0] > 0; });
    ASSERT_NE(begin, bench.poses.end());
    double worst = 1e9;
    for (int delay = 0; delay <= 60; delay++) {
        double error = 0;
        for (auto pose = begin; pose != bench.poses.end(); pose++) {
            double const u = std::clamp((static_cast<double>(pose - begin) + delay) * 0.001, 0.0, 1.0);
            double const x = 10000 * u * u * u * (10 - 15 * u + 6 * u * u);
            error = std::max(error, std::abs(x - pose->position_counts[0]));
        }
        worst = std::min(worst, error);
    }
    EXPECT_LE(worst, 0.5 + 1e-6);
}

TEST(Motion, path_waits_for_start) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    bench.begin_move(3, 1000, 1.0, false);
    bench.run(1500 * ms);
    EXPECT_EQ(bench.drives[0].position, 0);
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_motion_begin_tag;
    r.body.motion_begin = {3, 2, true};
    std::uint32_t const id = bench.request(r);
    bench.run(1500 * ms);
    EXPECT_EQ(bench.reply(id)->code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(bench.drives[0].position, 1000);
}

TEST(Motion, stop_holds_on_the_path_and_keeps_the_position) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    bench.set_output(gonio_Output_OUTPUT_SHUTTER, true);
    EXPECT_TRUE(bench.outputs[GN_OUT_SHUTTER]);
    bench.begin_move(1, 20000, 2.0);
    bench.run(1000 * ms);
    std::int32_t const at_stop = bench.drives[0].position;
    bench.shared.stop_requested++;
    bench.run(4 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_STOPPING);
    EXPECT_TRUE(bench.outputs[GN_OUT_SHUTTER]); // still moving
    bench.run(2000 * ms);
    EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_STOPPED);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
    EXPECT_FALSE(bench.outputs[GN_OUT_SHUTTER]);
    EXPECT_GT(bench.drives[0].position, at_stop);
    EXPECT_LT(bench.drives[0].position, 20000);
    EXPECT_EQ(bench.drives[0].position, bench.motion->axes[0].target_counts);
    EXPECT_EQ(bench.drives[0].status & 0x6F, 0x27);
    EXPECT_EQ(known_mask(bench), 0xFu);
    EXPECT_TRUE(bench.all(gonio_Event_fault_tag).empty());
    // Ready means ready: the next path begins where this one was held.
    bench.begin_move(2, 0, 3.0);
    bench.run(3500 * ms);
    EXPECT_EQ(bench.drives[0].position, 0);
}

TEST(Motion, speed_during_a_stop_falls_without_a_step) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    bench.begin_move(1, 20000, 2.0);
    bench.run(1000 * ms);
    bench.shared.stop_requested++;
    bench.run(2000 * ms);
    double const limit = 60 * counts_per_deg; // axis acceleration
    for (std::size_t i = 2; i < bench.poses.size(); i++) {
        double const bend = bench.poses[i].position_counts[0] - 2.0 * bench.poses[i - 1].position_counts[0] +
                            bench.poses[i - 2].position_counts[0];
        if (bench.poses[i - 2].sync_number > 600) { // after homing
            EXPECT_LE(std::abs(bend),
                      limit * 0.002 * 0.002 + 2.0); // second difference, and rounding of three positions
        }
    }
}

TEST(Motion, silent_host_expires_the_path_and_closes_the_shutter) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    bench.set_output(gonio_Output_OUTPUT_SHUTTER, true);
    bench.begin_move(1, 60000, 6.0);
    bench.run(1500 * ms);
    bench.host_alive = false;
    bench.shared.host_heard_ns = 0; // the driver has gone
    bench.run(500 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_MOVING);
    bench.run(220 * ms); // a stop may take 2.304 s of the 3
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_STOPPING);
    bench.run(2000 * ms);
    EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_EXPIRED);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
    EXPECT_FALSE(bench.outputs[GN_OUT_SHUTTER]);
    EXPECT_EQ(known_mask(bench), 0xFu);
}

TEST(Motion, silent_host_closes_the_shutter_at_rest_too) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    bench.set_output(gonio_Output_OUTPUT_SHUTTER, true);
    bench.set_output(gonio_Output_OUTPUT_LAMP, true);
    bench.host_alive = false;
    bench.run(500 * ms);
    EXPECT_TRUE(bench.outputs[GN_OUT_SHUTTER]);
    bench.run(2500 * ms);
    EXPECT_FALSE(bench.outputs[GN_OUT_SHUTTER]);
    EXPECT_TRUE(bench.outputs[GN_OUT_LAMP]);
    gonio_SetOutput const last = bench.all(gonio_Event_output_tag).back().body.output;
    EXPECT_EQ(last.output, gonio_Output_OUTPUT_SHUTTER);
    EXPECT_FALSE(last.on);
}

// A swing that uses the acceleration limit but for what the hold is guaranteed: |q''| + 0.5/s |q'| = limit at its
// worst.
void begin_steep_swing(Bench &bench, int seconds) {
    constexpr double w = 3.5;
    double const amplitude = 0.999 * 60 * counts_per_deg / (w * std::hypot(w, 0.5));
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_motion_begin_tag;
    std::uint32_t const knots = static_cast<std::uint32_t>(seconds) * 20;
    r.body.motion_begin = {6, knots + 100, true};
    bench.request(r);
    bench.push_knot(6, 0, 0, 0);
    for (std::uint32_t i = 1; i <= knots; i++) {
        double const t = 2.0 + 0.05 * i; // 2 s to build up the acceleration of the swing's turning point
        double const angle = w * 0.05 * (i - 1);
        gn_knot_item item{};
        item.path_id = 6;
        item.number = i;
        item.knot.time_ns = std::llround(t * 1e9);
        item.knot.position_counts[0] = amplitude * (std::cos(angle) - 1);
        item.knot.velocity_counts_per_s[0] = -amplitude * w * std::sin(angle);
        item.knot.acceleration_counts_per_s2[0] = -amplitude * w * w * std::cos(angle);
        for (int axis = 1; axis < 4; axis++) {
            item.knot.position_counts[axis] = bench.motion->axes[axis].target_counts;
        }
        EXPECT_TRUE(gn_ring_push(&bench.shared.knots, &item));
    }
}

TEST(Motion, silent_host_is_stood_still_and_dark_for_at_its_expiry_also_on_the_steepest_path) {
    for (std::int64_t begin_ms = 3000; begin_ms < 4800; begin_ms += 150) { // a period of the swing
        Bench bench;
        ASSERT_NO_FATAL_FAILURE(bench.make_ready());
        bench.set_output(gonio_Output_OUTPUT_SHUTTER, true);
        begin_steep_swing(bench, 12);
        bench.run(begin_ms * ms);
        ASSERT_EQ(bench.motion->state, gonio_InstrumentState_STATE_MOVING)
            << bench.all(gonio_Event_log_tag).at(0).body.log.text;
        bench.host_alive = false;
        std::int64_t const last_word_ns = bench.shared.host_heard_ns;
        while (bench.motion->state != gonio_InstrumentState_STATE_READY && bench.now_ns < last_word_ns + 3000 * ms) {
            bench.run(2 * ms);
            if (bench.motion->path.state != GN_PATH_IDLE) {
                EXPECT_TRUE(bench.outputs[GN_OUT_SHUTTER]) << "what the hold passes is measured";
            }
        }
        bench.run(last_word_ns + 2950 * ms - bench.now_ns); // a shutter takes its time
        EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_EXPIRED);
        EXPECT_FALSE(bench.outputs[GN_OUT_SHUTTER]);
        std::int32_t const standing = bench.drives[0].position;
        bench.run(500 * ms);
        EXPECT_EQ(bench.drives[0].position, standing);
    }
}

// 200 knots of a path announced with 400: up to 2000 counts/s in a second, then 20 ms apart at that speed.
void begin_cut_path(Bench &bench) {
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_motion_begin_tag;
    r.body.motion_begin = {5, 400, true};
    bench.request(r);
    bench.push_knot(5, 0, 0, 0);
    for (std::uint32_t i = 1; i < 200; i++) {
        bench.push_knot(5, i, 1'000'000'000 + (i - 1) * 20'000'000LL, 1000 + 40.0 * (i - 1), 2000);
    }
}

TEST(Motion, host_that_sends_too_slowly_is_an_underrun) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    begin_cut_path(bench);
    bench.run(8000 * ms);
    gonio_Fault const fault = bench.only_fault();
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_UNDERRUN);
    EXPECT_NE(std::string(fault.sentence).find("path 5 ran out of knots"), std::string::npos);
    EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_FAULT);
    EXPECT_LE(bench.drives[0].position, 1000 + 40 * 198);
}

TEST(Motion, host_that_died_before_the_underrun_is_an_expiry) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    begin_cut_path(bench);
    bench.run(4500 * ms);
    bench.host_alive = false;
    bench.run(4000 * ms);
    EXPECT_TRUE(bench.all(gonio_Event_fault_tag).empty());
    EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_EXPIRED);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
}

TEST(Motion, host_that_dies_after_it_caught_up_with_an_underrun_is_an_expiry) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    begin_cut_path(bench); // 4.96 s of knots
    while (bench.motion->ride.underrun_ns == 0 && bench.now_ns < 20'000 * ms) {
        bench.run(2 * ms);
    }
    for (std::uint32_t i = 200; i < 300; i++) { // two seconds more
        bench.push_knot(5, i, 1'000'000'000 + (i - 1) * 20'000'000LL, 1000 + 40.0 * (i - 1), 2000);
    }
    bench.run(1000 * ms);
    EXPECT_EQ(bench.motion->path.feed, 1.0);
    EXPECT_EQ(bench.motion->ride.underrun_ns, 0);
    bench.host_alive = false;
    bench.run(4000 * ms);
    EXPECT_TRUE(bench.all(gonio_Event_fault_tag).empty());
    EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_EXPIRED);
}

TEST(Motion, refused_knot_ends_the_path_with_a_sentence) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    bench.begin_move(9, 10000, 0.1); // far beyond the speed limit
    bench.run(500 * ms);
    EXPECT_EQ(bench.drives[0].position, 0);
    EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_STOPPED);
    auto const logs = bench.all(gonio_Event_log_tag);
    ASSERT_EQ(logs.size(), 1u);
    EXPECT_EQ(logs[0].body.log.level, 3u);
    EXPECT_GT(std::strlen(logs[0].body.log.text), 10u);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
    EXPECT_EQ(gn_ring_fill(&bench.shared.knots), 0u);
}

TEST(Motion, path_is_refused_before_homing_and_while_one_runs) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.boot());
    std::uint32_t const early = bench.begin_move(1, 1000, 1.0);
    bench.run(10 * ms);
    EXPECT_EQ(bench.reply(early)->code, gonio_ReplyCode_REPLY_REFUSED);
    EXPECT_EQ(gn_ring_fill(&bench.shared.knots), 0u); // its knots are gone too
    ASSERT_NO_FATAL_FAILURE({
        bench.home();
        bench.run(1000 * ms);
    });
    bench.begin_move(2, 1000, 1.0);
    bench.run(100 * ms);
    gonio_Request r = gonio_Request_init_zero;
    r.which_body = gonio_Request_motion_begin_tag;
    r.body.motion_begin = {3, 2, true};
    std::uint32_t const second = bench.request(r);
    bench.run(10 * ms);
    EXPECT_EQ(bench.reply(second)->code, gonio_ReplyCode_REPLY_REFUSED);
}

TEST(Motion, late_and_lost_frames_leave_flags_and_the_counters) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    int frames = 0;
    bench.meddle = [&frames](gn_can_frame &frame, std::int64_t &delay_ns) {
        if (frame.id != 0x183) {
            return false;
        }
        frames++;
        delay_ns = frames == 20 ? 2'100'000 : 0; // comes after the next SYNC's echo
        return frames == 40;                     // lost
    };
    bench.poses.clear();
    bench.run(200 * ms);
    EXPECT_EQ(bench.shared.counters.tpdo_missing, 2u);
    EXPECT_EQ(bench.shared.counters.tpdo_duplicate, 1u);
    int invalid = 0;
    for (const gn_pose &pose : bench.poses) {
        invalid += pose.valid != 0xF;
        EXPECT_EQ(pose.valid | 0x4, 0xF);
    }
    EXPECT_EQ(invalid, 3);
    EXPECT_TRUE(bench.all(gonio_Event_fault_tag).empty());
}

TEST(Motion, strobe_edges_pass_unchanged_and_other_lines_become_events) {
    Bench bench;
    bench.edge(GN_LINE_STROBE, true);
    bench.edge(GN_LINE_STROBE, false);
    bench.edge(GN_LINE_DOOR, false);
    bench.run(ms);
    gn_edge edge{};
    ASSERT_TRUE(gn_ring_pop(&bench.shared.strobes, &edge));
    EXPECT_TRUE(edge.rising);
    EXPECT_EQ(edge.number, 1u);
    ASSERT_TRUE(gn_ring_pop(&bench.shared.strobes, &edge));
    EXPECT_FALSE(edge.rising);
    EXPECT_FALSE(gn_ring_pop(&bench.shared.strobes, &edge));
    auto const changes = bench.all(gonio_Event_input_tag);
    ASSERT_EQ(changes.size(), 1u);
    EXPECT_EQ(changes[0].body.input.line, static_cast<std::uint32_t>(GN_LINE_DOOR));
    EXPECT_FALSE(changes[0].body.input.level);
}

TEST(Motion, status_comes_every_100_ms_and_the_watchdog_every_cycle) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.make_ready());
    bench.events.clear();
    bench.pulses = 0;
    bench.run(1000 * ms);
    EXPECT_EQ(bench.all(gonio_Event_status_tag).size(), 10u);
    EXPECT_EQ(bench.pulses, 500);
}

} // namespace
} // namespace gonio::test
