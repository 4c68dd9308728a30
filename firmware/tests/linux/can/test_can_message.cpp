// test_can_message.cpp: messages as the kernel's raw CAN socket gives them (Documentation/networking/can.rst).
#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <sys/socket.h>
#include <unistd.h>

extern "C" {
#include "can_message.h"
}

namespace {

constexpr int from_this_socket = MSG_DONTROUTE | MSG_CONFIRM;
constexpr int from_this_machine = MSG_DONTROUTE;

gn_can_message_kind kind(canid_t id, int flags, std::size_t length = sizeof(can_frame), int dlc = 8) {
    gn_can_message message{};
    msghdr header{};
    message.frame.can_id = id;
    message.frame.can_dlc = static_cast<std::uint8_t>(dlc);
    header.msg_flags = flags;
    gn_can_message_take_apart(&message, &header, length);
    return message.kind;
}

TEST(Can_message, of_our_own_frames_only_sync_comes_back) {
    EXPECT_EQ(kind(0x080, from_this_socket), GN_MESSAGE_ECHO);
    EXPECT_EQ(kind(0x201, from_this_socket), GN_MESSAGE_OTHER);
    EXPECT_EQ(kind(0x601, from_this_socket), GN_MESSAGE_OTHER);
}

// The twin's drives on a virtual bus are processes of the same machine.
TEST(Can_message, frames_of_other_processes_are_nodes_frames) {
    EXPECT_EQ(kind(0x181, from_this_machine), GN_MESSAGE_DATA);
    EXPECT_EQ(kind(0x080, from_this_machine), GN_MESSAGE_DATA);
    EXPECT_EQ(kind(0x181, 0), GN_MESSAGE_DATA);
}

TEST(Can_message, what_the_core_does_not_know_is_kept_from_it) {
    EXPECT_EQ(kind(CAN_ERR_FLAG | 0x40, 0), GN_MESSAGE_ERROR);
    EXPECT_EQ(kind(CAN_EFF_FLAG | 0x181, 0), GN_MESSAGE_OTHER);
    EXPECT_EQ(kind(CAN_RTR_FLAG | 0x701, 0), GN_MESSAGE_OTHER);
    EXPECT_EQ(kind(0x181, 0, CANFD_MTU), GN_MESSAGE_OTHER);
    EXPECT_EQ(kind(0x181, 0, sizeof(can_frame), 9), GN_MESSAGE_OTHER);
}

TEST(Can_message, stamp_and_losses_stand_beside_the_frame) {
    gn_can_message message{};
    msghdr header{};
    alignas(cmsghdr) char control[CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t))] = {};
    header.msg_control = control;
    header.msg_controllen = sizeof control;
    cmsghdr *c = CMSG_FIRSTHDR(&header);
    timespec const stamp = {1'700'000'000, 123'456'789};
    *c = {CMSG_LEN(sizeof stamp), SOL_SOCKET, SCM_TIMESTAMPNS};
    std::memcpy(CMSG_DATA(c), &stamp, sizeof stamp);
    c = CMSG_NXTHDR(&header, c);
    std::uint32_t const lost = 42;
    *c = {CMSG_LEN(sizeof lost), SOL_SOCKET, SO_RXQ_OVFL};
    std::memcpy(CMSG_DATA(c), &lost, sizeof lost);
    gn_can_message_take_apart(&message, &header, sizeof(can_frame));
    EXPECT_TRUE(message.stamped);
    EXPECT_EQ(message.real_ns, 1'700'000'000'123'456'789);
    EXPECT_TRUE(message.counted);
    EXPECT_EQ(message.lost, 42u);
    header.msg_controllen = 0;
    gn_can_message_take_apart(&message, &header, sizeof(can_frame));
    EXPECT_FALSE(message.stamped);
    EXPECT_FALSE(message.counted);
}

TEST(Can_message, frames_pass_a_socket_unchanged) {
    int ends[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_DGRAM, 0, ends), 0);
    gn_can_frame frame{};
    frame.id = 0x203;
    frame.length = 6;
    for (int i = 0; i < 6; i++) {
        frame.data[i] = static_cast<std::uint8_t>(0x10 + i);
    }
    gn_can_message message{};
    EXPECT_EQ(gn_can_message_receive(ends[1], &message), 0); // does not wait
    EXPECT_EQ(gn_can_message_send(ends[0], &frame), 0);
    ASSERT_EQ(gn_can_message_receive(ends[1], &message), 1);
    EXPECT_EQ(message.frame.can_id, 0x203u);
    EXPECT_EQ(message.frame.can_dlc, 6);
    EXPECT_EQ(std::memcmp(message.frame.data, frame.data, 8), 0);
    EXPECT_EQ(message.kind, GN_MESSAGE_DATA);
    close(ends[1]);
    EXPECT_LT(gn_can_message_send(ends[0], &frame), 0);
    close(ends[0]);
    EXPECT_EQ(gn_can_message_receive(ends[0], &message), -EBADF);
}

} // namespace
