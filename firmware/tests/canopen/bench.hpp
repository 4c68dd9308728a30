// bench.hpp: the real-time thread on a bus of scripted drives, in virtual time, with the host's side of the rings.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "../base/no_malloc.hpp"
#include "scripted_drive.hpp"

extern "C" {
#include "motion.h"
#include "motion_state.h"
#include "notice.h"
}

namespace gonio::test {

constexpr std::int64_t ms = 1'000'000;
constexpr double counts_per_deg = 10000.0 / 9.0;

class Bench {
public:
    Bench() {
        gn_shared_init(&shared);
        for (std::uint32_t node = 1; node <= 4; node++) {
            drives.emplace_back(node);
        }
        port.can = {this, &send, &receive, &bus_status};
        port.edge = {this, &edge_receive, &edge_level};
        port.out = {this, &out_set, &out_pulse, &out_operator};
        port.log = {this, &log_write};
        motion = gn_motion_init(&port, &shared);
    }

    // Requests ------------------------------------------------------------------------------------------------------
    static gonio_Configure configure_message() {
        gonio_Configure c = gonio_Configure_init_zero;
        c.axis_count = 4;
        c.sync_period_us = 2000;
        c.sync_window_us = 1500;
        c.firmware_heartbeat_ms = 100;
        c.drive_heartbeat_ms = 100;
        c.heartbeat_timeout_ms = 300;
        c.rpdo_deadline_syncs = 3;
        c.sdo_timeout_ms = 200;
        c.boot_timeout_ms = 2000;
        c.expiry_ms = 3000;
        c.sample_period_us = 1000;
        c.samples_per_strobe = 10;
        return c;
    }
    static gonio_AxisConfig axis_message(std::uint32_t axis) {
        static const char *const names[] = {"sample azimuth", "sample roll", "arm azimuth", "arm elevation"};
        static const std::uint32_t orders[] = {2, 2, 1, 0};
        gonio_AxisConfig a = gonio_AxisConfig_init_zero;
        a.axis = axis;
        std::snprintf(a.name, sizeof a.name, "%s", names[axis]);
        a.node = axis + 1;
        a.counts_per_deg = counts_per_deg;
        a.min_counts = -200 * counts_per_deg;
        a.max_counts = 200 * counts_per_deg;
        a.max_velocity_counts_per_s = 30 * counts_per_deg;
        a.max_acceleration_counts_per_s2 = 60 * counts_per_deg;
        a.homing_method = 1;
        a.homing_fast_counts_per_s = 11111;
        a.homing_slow_counts_per_s = 1111;
        a.homing_acceleration_counts_per_s2 = 66667;
        a.homing_timeout_ms = 2000;
        a.homing_order = orders[axis];
        a.following_error_counts = 556;
        a.following_error_timeout_ms = 20;
        a.counts_per_turn = 400000;
        a.quick_stop_deceleration_counts_per_s2 = 222222;
        a.brake = axis == 3;
        a.gravity = axis == 3;
        return a;
    }
    std::uint32_t request(gonio_Request request) {
        gn_command command{};
        request.id = ++last_id;
        command.request = request;
        EXPECT_TRUE(gn_ring_push(&shared.commands, &command));
        return last_id;
    }
    std::uint32_t request(pb_size_t which) {
        gonio_Request r = gonio_Request_init_zero;
        r.which_body = which;
        return request(r);
    }
    void configure() {
        gonio_Request r = gonio_Request_init_zero;
        r.which_body = gonio_Request_configure_tag;
        r.body.configure = configure_message();
        request(r);
        for (std::uint32_t axis = 0; axis < 4; axis++) {
            r.which_body = gonio_Request_configure_axis_tag;
            r.body.configure_axis = axis_message(axis);
            request(r);
        }
        run(1 * ms);
    }
    std::uint32_t home(std::uint32_t mask = 0xF) {
        gonio_Request r = gonio_Request_init_zero;
        r.which_body = gonio_Request_home_tag;
        r.body.home.axis_mask = mask;
        return request(r);
    }
    void set_output(gonio_Output output, bool on) {
        gonio_Request r = gonio_Request_init_zero;
        r.which_body = gonio_Request_set_output_tag;
        r.body.set_output = {output, on};
        request(r);
        run(1 * ms);
    }
    void boot() {
        configure();
        request(gonio_Request_boot_tag);
        run(1000 * ms);
        ASSERT_EQ(motion->state, gonio_InstrumentState_STATE_UNHOMED) << motion->last_fault.sentence;
    }
    void make_ready() {
        ASSERT_NO_FATAL_FAILURE(boot());
        home();
        run(1000 * ms);
        ASSERT_EQ(motion->state, gonio_InstrumentState_STATE_READY) << motion->last_fault.sentence;
    }
    // Knots of one axis from rest to rest; the others stand. A sine-free straight move at the given speed.
    std::uint32_t begin_move(std::uint32_t path_id, double to_counts, double seconds, bool start = true) {
        gonio_Request r = gonio_Request_init_zero;
        r.which_body = gonio_Request_motion_begin_tag;
        r.body.motion_begin = {path_id, 2, start};
        std::uint32_t const id = request(r);
        push_knot(path_id, 0, 0, motion->axes[0].target_counts);
        push_knot(path_id, 1, static_cast<std::int64_t>(seconds * 1e9), to_counts);
        return id;
    }
    void push_knot(std::uint32_t path_id, std::uint32_t number, std::int64_t time_ns, double counts,
                   double velocity = 0) {
        gn_knot_item item{};
        item.path_id = path_id;
        item.number = number;
        item.knot.time_ns = time_ns;
        item.knot.position_counts[0] = counts;
        item.knot.velocity_counts_per_s[0] = velocity;
        for (int axis = 1; axis < 4; axis++) {
            item.knot.position_counts[axis] = motion->axes[axis].target_counts;
        }
        EXPECT_TRUE(gn_ring_push(&shared.knots, &item));
    }
    void edge(std::uint32_t line, bool rising) {
        levels[line] = rising;
        edges.push_back({line, ++edge_numbers[line], rising, now_ns});
    }

    // Time ----------------------------------------------------------------------------------------------------------
    void run(std::int64_t duration_ns) {
        std::int64_t const end_ns = now_ns + duration_ns;
        while (now_ns < end_ns) {
            if (host_alive) {
                shared.host_heard_ns = now_ns;
            }
            {
                In_core const core;
                wake_ns_ = gn_motion_process(motion, now_ns);
            }
            drain();
            std::int64_t next_ns = std::min(wake_ns_, end_ns);
            if (!arriving.empty()) {
                next_ns = std::min(next_ns, arriving.front().stamp_ns);
            }
            now_ns = std::max(next_ns, now_ns + 1000);
            if (now_ns >= next_heartbeat_ns_) {
                next_heartbeat_ns_ += 100 * ms;
                for (Scripted_drive &drive : drives) {
                    if (!drive.silent) {
                        arrive(drive.heartbeat());
                    }
                }
            }
        }
    }
    void arrive(gn_can_frame frame, std::int64_t delay_ns = 0) {
        bus_free_ns_ = std::max(bus_free_ns_, now_ns) + 100'000; // a frame takes 100 us
        frame.stamp_ns = bus_free_ns_ + delay_ns;
        arriving.push_back(frame);
        std::stable_sort(arriving.begin(), arriving.end(),
                         [](const auto &a, const auto &b) { return a.stamp_ns < b.stamp_ns; });
    }

    // What came back ------------------------------------------------------------------------------------------------
    const gonio_Reply *reply(std::uint32_t id) const {
        for (const gonio_Reply &r : replies) {
            if (r.id == id) {
                return &r;
            }
        }
        return nullptr;
    }
    const gonio_OperationDone *done(std::uint32_t id) const {
        for (const gonio_Event &e : events) {
            if (e.which_body == gonio_Event_done_tag && e.body.done.request_id == id) {
                return &e.body.done;
            }
        }
        return nullptr;
    }
    std::vector<gonio_Event> all(pb_size_t which) const {
        std::vector<gonio_Event> found;
        std::copy_if(events.begin(), events.end(), std::back_inserter(found),
                     [which](const gonio_Event &e) { return e.which_body == which; });
        return found;
    }
    gonio_Fault only_fault() const {
        auto const faults = all(gonio_Event_fault_tag);
        EXPECT_EQ(faults.size(), 1u);
        return faults.empty() ? gonio_Fault{} : faults[0].body.fault;
    }
    gonio_PathEnd last_path_end() const { return all(gonio_Event_path_tag).back().body.path.end; }

    gn_shared shared{};
    gn_port port{};
    gn_motion *motion = nullptr;
    std::vector<Scripted_drive> drives;
    std::vector<gonio_Reply> replies;
    std::vector<gonio_Event> events;
    std::vector<gn_pose> poses;
    std::vector<gn_can_frame> sent;
    std::vector<gn_can_frame> arriving;
    std::vector<gn_edge> edges;
    std::uint32_t edge_numbers[GN_LINE_COUNT] = {};
    bool levels[GN_LINE_COUNT] = {false, true, true, true, true};
    bool outputs[3] = {};
    std::uint32_t operator_action = 0;
    int pulses = 0;
    bool host_alive = true;
    bool echo_lost = false;
    gn_can_status bus{};
    std::int64_t now_ns = 1'000'000'000;
    std::uint32_t last_id = 0;
    // What the test does to frames on their way from the drives: true takes the frame away.
    std::function<bool(gn_can_frame &, std::int64_t &delay_ns)> meddle;

private:
    static Bench &self(void *context) { return *static_cast<Bench *>(context); }
    static int send(void *context, const gn_can_frame *frame) {
        In_port const port_called;
        Bench &b = self(context);
        b.sent.push_back(*frame);
        gn_can_frame echo = *frame;
        echo.own_echo = true;
        if (frame->id != 0x080 || !b.echo_lost) {
            b.arrive(echo);
        }
        for (Scripted_drive &drive : b.drives) {
            for (gn_can_frame answer : drive.on_frame(*frame)) {
                std::int64_t delay_ns = 0;
                if (!b.meddle || !b.meddle(answer, delay_ns)) {
                    b.arrive(answer, delay_ns);
                }
            }
        }
        return 0;
    }
    static int receive(void *context, gn_can_frame *frame) {
        In_port const port_called;
        Bench &b = self(context);
        if (b.arriving.empty() || b.arriving.front().stamp_ns > b.now_ns) {
            return 0;
        }
        *frame = b.arriving.front();
        b.arriving.erase(b.arriving.begin());
        return 1;
    }
    static void bus_status(void *context, gn_can_status *status) { *status = self(context).bus; }
    static int edge_receive(void *context, gn_edge *edge) {
        In_port const port_called;
        Bench &b = self(context);
        if (b.edges.empty()) {
            return 0;
        }
        *edge = b.edges.front();
        b.edges.erase(b.edges.begin());
        return 1;
    }
    static bool edge_level(void *context, std::uint32_t line) { return self(context).levels[line]; }
    static void out_set(void *context, std::uint32_t output, bool on) { self(context).outputs[output] = on; }
    static void out_pulse(void *context) { self(context).pulses++; }
    static void out_operator(void *context, std::uint32_t action) { self(context).operator_action = action; }
    static void log_write(void *, gn_log_level, const char *) {}

    void drain() {
        gn_notice notice{};
        while (gn_ring_pop(&shared.notices, &notice)) {
            if (notice.is_reply) {
                replies.push_back(notice.as.reply);
            } else {
                events.push_back(notice.as.event);
            }
        }
        gn_pose pose{};
        while (gn_ring_pop(&shared.poses, &pose)) {
            poses.push_back(pose);
        }
    }

    std::int64_t wake_ns_ = 0;
    std::int64_t next_heartbeat_ns_ = 1'000'000'000;
    std::int64_t bus_free_ns_ = 0;
};

inline std::uint32_t known_mask(const Bench &bench) {
    return gn_known_mask(bench.motion);
}

} // namespace gonio::test
