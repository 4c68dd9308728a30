// test_threads.cpp: both threads in real time on scripted drives: boot, home, move, and the way out.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <linux/can.h>
#include <linux/can/error.h>
#include <memory>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "../../canopen/bench.hpp"
#include "live_drives.hpp"

extern "C" {
#include "can_socket_state.h"
#include "motion_state.h"
}

namespace gonio::test {
namespace {

constexpr auto patience = std::chrono::seconds(60); // for a machine under load; nothing here takes a second

// The stream thread's place is taken by the caller; the host's side of the rings by its `alive`, on that very thread.
class Threads : public testing::Test {
protected:
    Threads() {
        gn_shared_init(shared.get());
        motion = gn_motion_init(&world.port, shared.get());
        stream = gn_stream_init(&world.port, shared.get(), "threads", 1);
        world.watched = true;
        stop_fd = eventfd(0, EFD_CLOEXEC);
    }
    ~Threads() override { close(stop_fd); }

    void request(gonio_Request r) {
        gn_command command{};
        r.id = ++last_id;
        command.request = r;
        ASSERT_TRUE(gn_ring_push(&shared->commands, &command));
    }
    void request(pb_size_t which) {
        gonio_Request r = gonio_Request_init_zero;
        r.which_body = which;
        request(r);
    }
    void configure() {
        gonio_Request r = gonio_Request_init_zero;
        r.which_body = gonio_Request_configure_tag;
        r.body.configure = Bench::configure_message();
        r.body.configure.sync_period_us = 10'000; // a busy machine misses cycles; the drives here do not mind
        r.body.configure.heartbeat_timeout_ms = 20'000;
        r.body.configure.boot_timeout_ms = 20'000;
        r.body.configure.sdo_timeout_ms = 5'000;
        r.body.configure.expiry_ms = 20'000;
        request(r);
        for (std::uint32_t axis = 0; axis < 4; axis++) {
            r = gonio_Request_init_zero;
            r.which_body = gonio_Request_configure_axis_tag;
            r.body.configure_axis = Bench::axis_message(axis);
            r.body.configure_axis.homing_timeout_ms = 20'000;
            request(r);
        }
    }
    gonio_InstrumentState state() const { return __atomic_load_n(&motion->state, __ATOMIC_RELAXED); }
    void end() {
        std::uint64_t const one = 1;
        ASSERT_EQ(write(stop_fd, &one, sizeof one), static_cast<ssize_t>(sizeof one));
    }
    int run() {
        gn_threads threads{};
        threads.motion = motion;
        threads.stream = stream;
        threads.shared = shared.get();
        threads.can = served_can;
        threads.stop_fd = stop_fd;
        threads.alive = [](void *context) { static_cast<Threads *>(context)->on_alive(); };
        threads.alive_context = this;
        gn_thread_settings const settings = {0, 0, -1};
        char error[160] = "";
        started = std::chrono::steady_clock::now();
        int const result = gn_threads_run(&threads, &settings, error, sizeof error);
        EXPECT_STREQ(error, "");
        return result;
    }
    void on_alive() {
        alive_calls++;
        if (std::chrono::steady_clock::now() - started > patience && !late) {
            late = true;
            end();
        }
        // There is no link, so the stream side reports a host that never spoke; the core keeps the latest word.
        __atomic_store_n(&motion->heard_ns, gn_monotonic_ns(), __ATOMIC_RELAXED);
        if (!late && step) {
            step();
        }
    }

    std::unique_ptr<gn_shared> shared = std::make_unique<gn_shared>();
    Live_drives world;
    gn_motion *motion = nullptr;
    gn_stream *stream = nullptr;
    int stop_fd = -1;
    gn_can_socket *served_can = nullptr;
    std::uint32_t last_id = 0;
    int alive_calls = 0;
    int phase = 0;
    bool late = false; // patience ran out
    std::function<void()> step;
    std::chrono::steady_clock::time_point started;
};

TEST_F(Threads, run_until_they_are_told_to_end) {
    step = [this] {
        if (alive_calls == 3) {
            end();
        }
    };
    EXPECT_EQ(run(), 0);
    EXPECT_FALSE(late);
    EXPECT_GE(alive_calls, 3);
    EXPECT_GT(shared->motion_latency.wakeups, 0u); // the status each 100 ms is a timed wake-up
    EXPECT_GT(shared->stream_latency.wakeups, 0u);
    EXPECT_EQ(shared->stop_requested, 1u);
}

// The real-time thread boots, homes and moves four drives, and the order to end comes in the middle of a path with the
// shutter open. Any use of the heap on it would have ended this program.
TEST_F(Threads, end_stops_on_the_path_and_leaves_it_dark_without_a_heap) {
    step = [this] {
        switch (phase) {
        case 0:
            configure();
            request(gonio_Request_boot_tag);
            phase = 1;
            break;
        case 1:
            if (state() == gonio_InstrumentState_STATE_UNHOMED) {
                gonio_Request r = gonio_Request_init_zero;
                r.which_body = gonio_Request_home_tag;
                r.body.home.axis_mask = 0xF;
                request(r);
                phase = 2;
            }
            break;
        case 2:
            if (state() == gonio_InstrumentState_STATE_READY) {
                gonio_Request r = gonio_Request_init_zero;
                r.which_body = gonio_Request_set_output_tag;
                r.body.set_output = {gonio_Output_OUTPUT_SHUTTER, true};
                request(r);
                for (std::uint32_t knot = 0; knot < 2; knot++) {
                    gn_knot_item item{};
                    item.path_id = 7;
                    item.number = knot;
                    item.knot.time_ns = knot * 100'000'000'000;
                    item.knot.position_counts[0] = knot * 100'000.0;
                    ASSERT_TRUE(gn_ring_push(&shared->knots, &item));
                }
                r = gonio_Request_init_zero;
                r.which_body = gonio_Request_motion_begin_tag;
                r.body.motion_begin = {7, 2, true};
                request(r);
                phase = 3;
            }
            break;
        default:
            if (__atomic_load_n(&motion->path.state, __ATOMIC_RELAXED) == GN_PATH_RUNNING &&
                __atomic_load_n(&motion->path.time_ns, __ATOMIC_RELAXED) > 1'000'000'000) {
                phase = 4;
                end();
                step = nullptr;
            }
            break;
        }
    };
    EXPECT_EQ(run(), 0);
    EXPECT_FALSE(late) << "in phase " << phase << ", state " << state() << " " << motion->last_fault.sentence;
    EXPECT_EQ(phase, 4);
    EXPECT_EQ(state(), gonio_InstrumentState_STATE_READY) << motion->last_fault.sentence; // stopped, and still known
    EXPECT_EQ(motion->path.state, GN_PATH_IDLE);
    EXPECT_FALSE(world.outputs[GN_OUT_SHUTTER]);
    EXPECT_LT(world.drives[0].position, 100'000);
    EXPECT_NEAR(world.drives[0].position, motion->axes[0].target_counts, 1.0);
}

// The CAN port itself: frames, an error frame, and an interface that goes away.
TEST_F(Threads, the_can_port_uses_no_heap) {
    static gn_can_socket can; // as its own instance is
    static gn_can_port port;
    int ends[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, ends), 0);
    can = {};
    can.net_folder = "/nonexistent";
    gn_can_socket_adopt(&can, ends[0]);
    gn_can_socket_port(&can, &port);
    world.port.can = port;
    world.port.can.receive = [](void *context, gn_can_frame *frame) {
        forbid_heap(true);
        return port.receive(context, frame);
    };
    served_can = &can;
    step = [&] {
        can_frame frame{};
        switch (phase) {
        case 0:
            for (canid_t const id : {canid_t{0x181}, canid_t{CAN_ERR_FLAG | CAN_ERR_BUSERROR}, canid_t{0x701}}) {
                frame.can_id = id;
                ASSERT_EQ(write(ends[1], &frame, sizeof frame), static_cast<ssize_t>(sizeof frame));
            }
            phase = 1;
            break;
        case 1:
            if (__atomic_load_n(&can.health.error_frames, __ATOMIC_RELAXED) == 1) {
                close(ends[1]);
                phase = 2;
            }
            break;
        default:
            if (__atomic_load_n(&can.health.state, __ATOMIC_RELAXED) == GN_CAN_DOWN) {
                end();
                step = nullptr;
            }
            break;
        }
    };
    EXPECT_EQ(run(), 0);
    EXPECT_FALSE(late) << "in phase " << phase;
    EXPECT_EQ(gn_can_socket_fd(&can), -1); // given up
}

} // namespace
} // namespace gonio::test
