// live_drives.hpp: scripted drives that answer at once, in real time, behind a port that lives on the real-time thread.
#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "../../canopen/scripted_drive.hpp"
#include "no_allocation.hpp"

extern "C" {
#include "port.h"
#include "threads.h"
}

namespace gonio::test {

// From the first call on, the core and the loop around it may not use the heap; the drives may.
class Live_drives {
public:
    Live_drives() {
        for (std::uint32_t node = 1; node <= 4; node++) {
            drives.emplace_back(node);
        }
        port.can = {this, &send, &receive, &bus_status};
        port.edge = {this, &edge_receive, &edge_level};
        port.out = {this, &out_set, &out_pulse, &out_operator};
        port.digitiser = {this, [](void *, std::uint32_t, std::uint32_t) { return -1; }, [](void *) {},
                          [](void *, std::uint8_t *, std::size_t) { return -1; }};
        port.link = {this, [](void *, std::uint32_t, std::uint8_t *, std::size_t) { return -1; },
                     [](void *, std::uint32_t, const std::uint8_t *, std::size_t) { return -1; },
                     [](void *, std::uint32_t) {}};
        port.log = {this, [](void *, gn_log_level, const char *) {}};
    }

    std::vector<Scripted_drive> drives;
    gn_port port{};
    bool watched = false; // gn_motion_init, on the test's own thread, is not
    std::array<bool, 3> outputs{};
    std::int64_t last_heartbeat_ns = 0;

private:
    static Live_drives &self(void *context) { return *static_cast<Live_drives *>(context); }
    void arrive(gn_can_frame frame) {
        frame.stamp_ns = gn_monotonic_ns();
        waiting_.push_back(frame);
    }
    void heartbeats() {
        std::int64_t const now_ns = gn_monotonic_ns();
        if (now_ns - last_heartbeat_ns > 50'000'000) {
            last_heartbeat_ns = now_ns;
            for (const Scripted_drive &drive : drives) {
                arrive(drive.heartbeat());
            }
        }
    }
    static int send(void *context, const gn_can_frame *frame) {
        Heap_allowed const allowed;
        Live_drives &bus = self(context);
        gn_can_frame echo = *frame;
        echo.own_echo = true;
        if (frame->id == 0x080) {
            bus.arrive(echo);
        }
        for (Scripted_drive &drive : bus.drives) {
            for (gn_can_frame const &answer : drive.on_frame(*frame)) {
                bus.arrive(answer);
            }
        }
        return 0;
    }
    static int receive(void *context, gn_can_frame *frame) {
        Live_drives &bus = self(context);
        int got = 0;
        {
            Heap_allowed const allowed;
            bus.heartbeats();
            if (!bus.waiting_.empty()) {
                *frame = bus.waiting_.front();
                bus.waiting_.pop_front();
                got = 1;
            }
        }
        forbid_heap(bus.watched);
        return got;
    }
    static void bus_status(void *, gn_can_status *status) { *status = {}; }
    static int edge_receive(void *, gn_edge *) { return 0; }
    static bool edge_level(void *, std::uint32_t) { return true; }
    static void out_set(void *context, std::uint32_t output, bool on) { self(context).outputs.at(output) = on; }
    static void out_pulse(void *) {}
    static void out_operator(void *, std::uint32_t) {}

    std::deque<gn_can_frame> waiting_;
};

} // namespace gonio::test
