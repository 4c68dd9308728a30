// test_can_socket.cpp: the CAN port on a socket pair in the place of a raw CAN socket: room, loss and return.
#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <linux/can/error.h>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

#include "net_folder.hpp"

extern "C" {
#include "can_socket_state.h"
#include "shared.h"
}

namespace gonio::test {
namespace {

std::int64_t monotonic_ns() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

gn_can_frame frame(std::uint32_t id, std::uint8_t first = 0) {
    gn_can_frame f{};
    f.id = id;
    f.length = 1;
    f.data[0] = first;
    return f;
}

// A datagram socket holds a few messages and then has no room, as a CAN interface's queue; the other end is the bus.
class Can_socket : public testing::Test {
protected:
    void SetUp() override {
        int ends[2];
        ASSERT_EQ(socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, ends), 0);
        int const on = 1;
        ASSERT_EQ(setsockopt(ends[0], SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on), 0);
        bus = ends[1];
        net.set("can0", 7, type_can, up);
        can.settings = {"can0", 2.5f};
        can.net_folder = net.path();
        can.index = 7;
        gn_can_socket_adopt(&can, ends[0]);
        gn_can_socket_port(&can, &port);
    }
    void TearDown() override {
        gn_can_socket_close(&can);
        close(bus);
    }
    int send(const gn_can_frame &f) { return port.send(port.context, &f); }
    gn_can_status status() {
        gn_can_status s{};
        port.status(port.context, &s);
        return s;
    }
    void on_bus(canid_t id, int second = 0) {
        can_frame f{};
        f.can_id = id;
        f.can_dlc = 8;
        f.data[1] = static_cast<std::uint8_t>(second);
        ASSERT_EQ(write(bus, &f, sizeof f), static_cast<ssize_t>(sizeof f));
    }
    // What has left, in order.
    std::vector<can_frame> left() {
        std::vector<can_frame> frames;
        can_frame f{};
        while (recv(bus, &f, sizeof f, MSG_DONTWAIT) == static_cast<ssize_t>(sizeof f)) {
            frames.push_back(f);
        }
        return frames;
    }
    bool receive(gn_can_frame &f) { return port.receive(port.context, &f) == 1; }

    Net_folder net;
    gn_can_socket can{};
    gn_can_port port{};
    int bus = -1;
};

TEST_F(Can_socket, frames_leave_at_once_where_there_is_room) {
    EXPECT_EQ(send(frame(0x080, 3)), 0);
    EXPECT_EQ(gn_can_socket_process(&can, monotonic_ns()), GN_NEVER_NS);
    auto const frames = left();
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_EQ(frames[0].can_id, 0x080u);
    EXPECT_EQ(frames[0].data[0], 3);
}

TEST_F(Can_socket, without_room_setpoints_are_renewed_and_nothing_else_is_lost) {
    int in_kernel = 0;
    while (can.queue.count == 0) {
        ASSERT_EQ(send(frame(0x601, static_cast<std::uint8_t>(in_kernel++))), 0);
        ASSERT_LT(in_kernel, 1000);
    }
    for (std::uint8_t cycle = 1; cycle <= 5; cycle++) {
        ASSERT_EQ(send(frame(0x080, cycle)), 0);
        ASSERT_EQ(send(frame(0x201, cycle)), 0);
    }
    EXPECT_EQ(status().setpoints_dropped, 4u);
    EXPECT_NE(can.retry_ns, 0);
    EXPECT_EQ(gn_can_socket_process(&can, can.retry_ns - 1), can.retry_ns); // says when it wants to try again
    std::vector<can_frame> frames;
    for (int tries = 0; tries < 1000 && can.queue.count > 0; tries++) {
        for (auto const &f : left()) {
            frames.push_back(f);
        }
        gn_can_socket_process(&can, can.retry_ns);
    }
    for (auto const &f : left()) {
        frames.push_back(f);
    }
    ASSERT_EQ(frames.size(), static_cast<std::size_t>(in_kernel) + 6u);
    for (int i = 0; i < in_kernel; i++) {
        EXPECT_EQ(frames[static_cast<std::size_t>(i)].data[0], i % 256);
    }
    for (std::size_t i = 0; i < 5; i++) {
        EXPECT_EQ(frames[static_cast<std::size_t>(in_kernel) + i].can_id, 0x080u);
        EXPECT_EQ(frames[static_cast<std::size_t>(in_kernel) + i].data[0], i + 1);
    }
    EXPECT_EQ(frames.back().can_id, 0x201u);
    EXPECT_EQ(frames.back().data[0], 5);
    EXPECT_EQ(gn_can_socket_process(&can, monotonic_ns()), GN_NEVER_NS);
}

TEST_F(Can_socket, stamps_are_controller_time) {
    std::int64_t const before_ns = monotonic_ns();
    on_bus(0x181);
    std::int64_t const after_ns = monotonic_ns();
    gn_can_frame f{};
    ASSERT_TRUE(receive(f));
    EXPECT_EQ(f.id, 0x181u);
    EXPECT_FALSE(f.own_echo);
    EXPECT_FALSE(f.stamp_by_arrival);
    EXPECT_GE(f.stamp_ns, before_ns - GN_CLOCK_STEP_NS);
    EXPECT_LE(f.stamp_ns, after_ns + GN_CLOCK_STEP_NS);
    EXPECT_FALSE(receive(f));
    EXPECT_EQ(status().clock_steps, 0u);
    EXPECT_EQ(status().sync_stamp_sigma_us, 2.5f);
}

TEST_F(Can_socket, error_frames_become_status_and_never_reach_the_core) {
    on_bus(CAN_ERR_FLAG | CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE);
    on_bus(CAN_EFF_FLAG | 0x12345);
    on_bus(0x701);
    gn_can_frame f{};
    ASSERT_TRUE(receive(f));
    EXPECT_EQ(f.id, 0x701u);
    EXPECT_EQ(status().state, GN_CAN_ERROR_PASSIVE);
    EXPECT_EQ(status().error_frames, 1u);
}

TEST_F(Can_socket, bus_off_takes_no_frames_that_would_leave_too_late) {
    int in_kernel = 0;
    while (can.queue.count < 2) {
        ASSERT_EQ(send(frame(0x080)), 0);
        ASSERT_LT(++in_kernel, 1000);
    }
    on_bus(CAN_ERR_FLAG | CAN_ERR_BUSOFF);
    gn_can_frame f{};
    EXPECT_FALSE(receive(f));
    EXPECT_EQ(status().state, GN_CAN_BUS_OFF);
    EXPECT_EQ(status().bus_offs, 1u);
    EXPECT_EQ(can.queue.count, 0u);
    EXPECT_EQ(send(frame(0x080)), -1);
    left();
    on_bus(CAN_ERR_FLAG | CAN_ERR_RESTARTED);
    EXPECT_FALSE(receive(f));
    gn_can_socket_process(&can, can.retry_ns);
    EXPECT_EQ(send(frame(0x000)), 0);
    EXPECT_EQ(left().size(), 1u);
}

TEST_F(Can_socket, losses_of_all_its_sockets_add_up) {
    for (std::uint32_t lost = 3; lost <= 4; lost++) {
        int ends[2];
        ASSERT_EQ(socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, ends), 0);
        can.lost = lost; // as SO_RXQ_OVFL said last
        gn_can_socket_close(&can);
        gn_can_socket_adopt(&can, ends[0]);
        close(ends[1]);
    }
    can.lost = 5;
    can.health.chip_overflows = 1;
    EXPECT_EQ(status().receive_overflows, 13u);
}

TEST_F(Can_socket, an_interface_that_was_down_is_used_again) {
    gn_can_socket *const raw = &can;
    gn_bus_health_on_interface(&raw->health, false); // as ENETDOWN does
    net.set("can0", 7, type_can, down);
    std::int64_t const now_ns = monotonic_ns();
    std::int64_t const again_ns = gn_can_socket_process(&can, now_ns);
    EXPECT_GT(again_ns, now_ns);
    EXPECT_EQ(status().state, GN_CAN_DOWN);
    EXPECT_EQ(send(frame(0x080)), -1);
    net.set("can0", 7, type_can, up);
    EXPECT_EQ(gn_can_socket_process(&can, now_ns + 1), again_ns); // not at every call
    EXPECT_EQ(status().state, GN_CAN_DOWN);
    EXPECT_EQ(gn_can_socket_process(&can, again_ns), GN_NEVER_NS);
    EXPECT_EQ(status().state, GN_CAN_ERROR_ACTIVE);
    EXPECT_EQ(send(frame(0x080)), 0);
    EXPECT_EQ(left().size(), 1u);
}

// The kernel never binds a socket again whose interface was removed.
TEST_F(Can_socket, the_socket_of_a_removed_interface_is_given_up) {
    shutdown(bus, SHUT_RDWR); // sending fails for good, as with ENXIO
    EXPECT_EQ(send(frame(0x080)), 0);
    EXPECT_EQ(status().state, GN_CAN_DOWN);
    EXPECT_EQ(gn_can_socket_fd(&can), -1);
    net.remove("can0");
    std::int64_t const now_ns = monotonic_ns();
    EXPECT_GT(gn_can_socket_process(&can, now_ns), now_ns);
    gn_can_frame f{};
    EXPECT_FALSE(receive(f));
    EXPECT_EQ(send(frame(0x080)), -1);
}

TEST_F(Can_socket, another_interface_of_the_same_name_needs_another_socket) {
    gn_bus_health_on_interface(&can.health, false);
    net.set("can0", 9, type_can, down);
    gn_can_socket_process(&can, monotonic_ns());
    EXPECT_EQ(gn_can_socket_fd(&can), -1);
}

} // namespace
} // namespace gonio::test
