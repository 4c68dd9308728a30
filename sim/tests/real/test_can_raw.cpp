// test_can_raw.cpp: frames on a raw CAN socket, played by a pair of sockets that keep messages apart.
#include <array>
#include <vector>

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>

#include "can_raw.hpp"
#include "real_bench.hpp"

namespace gonio::sim {
namespace {

struct Pair {
    Pair() { EXPECT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends.data()), 0); }
    std::array<int, 2> ends{};
};

struct Wired {
    Wired() {
        wire.on_frame([this](const gn_can_frame &frame) { heard.push_back(frame); });
    }
    Pair pair;
    Scheduler scheduler{monotonic_ns()};
    std::vector<gn_can_frame> heard;
    Can_raw wire{scheduler, pair.ends[0]};
    Peer peer{pair.ends[1]};
};

can_frame raw_frame(std::uint32_t id, std::uint8_t length, std::uint8_t first) {
    can_frame frame{};
    frame.can_id = id;
    frame.can_dlc = length;
    frame.data[0] = first;
    return frame;
}

can_frame raw_of(const std::string &bytes) {
    can_frame frame{};
    EXPECT_EQ(bytes.size(), sizeof frame);
    std::memcpy(&frame, bytes.data(), std::min(bytes.size(), sizeof frame));
    return frame;
}

} // namespace

TEST(Can_raw, StandardDataFramesAreHeardWithAStampOfTheMonotonicClock) {
    Wired wired;
    std::int64_t const before_ns = monotonic_ns();
    wired.peer.say_block(raw_frame(0x601, 8, 0x40));
    wired.peer.say_block(raw_frame(0x601 | CAN_EFF_FLAG, 8, 0));
    wired.peer.say_block(raw_frame(0x601 | CAN_RTR_FLAG, 8, 0));
    wired.peer.say_block(raw_frame(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8, 0));
    wired.peer.say_block(raw_frame(0x080, 0, 0));
    wired.wire.serve();
    ASSERT_EQ(wired.heard.size(), 2U);
    EXPECT_EQ(wired.heard[0].id, 0x601U);
    EXPECT_EQ(wired.heard[0].length, 8);
    EXPECT_EQ(wired.heard[0].data[0], 0x40);
    EXPECT_GE(wired.heard[0].stamp_ns, before_ns);
    EXPECT_LE(wired.heard[0].stamp_ns, monotonic_ns());
    EXPECT_EQ(wired.heard[1].id, 0x080U);
}

TEST(Can_raw, FramesThatTheInterfaceDoesNotTakeWaitAndKeepTheirOrder) {
    Wired wired;
    int taken = 0;
    gn_can_frame frame{};
    frame.id = 0x181;
    frame.length = 4;
    // The socket's buffer is the interface's queue here: more than it holds, less than the wire's own queue.
    for (; taken < 100000; ++taken) {
        can_frame const raw = raw_frame(0x100, 1, 0);
        if (send(wired.pair.ends[0], &raw, sizeof raw, MSG_DONTWAIT) < 0) {
            break;
        }
    }
    ASSERT_LT(taken, 100000);
    for (std::uint8_t k = 0; k < 200; ++k) {
        frame.data[0] = k;
        wired.wire.send(frame);
    }
    for (int k = 0; k < taken; ++k) {
        ASSERT_EQ(raw_of(wired.peer.hear()).can_id, 0x100U);
    }
    EXPECT_EQ(wired.peer.hear_now(), "");
    for (int waited_ms = 1; waited_ms <= 5; ++waited_ms) {
        while (wired.scheduler.run_one(wired.scheduler.now_ns() + 1000000)) {
        }
    }
    for (int k = 0; k < 200; ++k) {
        can_frame const raw = raw_of(wired.peer.hear());
        ASSERT_EQ(raw.can_id, 0x181U);
        ASSERT_EQ(raw.can_dlc, 4);
        ASSERT_EQ(raw.data[0], k);
    }
    EXPECT_EQ(wired.wire.frames_dropped(), 0U);
}

TEST(Can_raw, AMissingInterfaceIsNamed) {
    Scheduler scheduler;
    try {
        Can_raw const wire(scheduler, "nocan7");
        FAIL() << "there is no such interface";
    } catch (const std::runtime_error &error) {
        EXPECT_NE(std::string(error.what()).find("nocan7"), std::string::npos) << error.what();
    }
}

// The whole way: an SDO read of the device type comes in, the drive's answer goes out.
TEST(Can_bridge, ADriveAnswersWhatTheWireCarries) {
    Real_bench bench(demo(), monotonic_ns());
    Pair pair;
    Can_raw wire(bench.apparatus.scheduler(), pair.ends[0]);
    Can_bridge bridge(bench.apparatus.scheduler(), bench.apparatus.bus(), wire);
    Peer const peer(pair.ends[1]);
    bench.run_ms(100);
    can_frame request = raw_frame(0x602, 8, 0x40);
    request.data[2] = 0x10;
    peer.say_block(request);
    wire.serve();
    bench.run_ms(5);
    can_frame answer{};
    do { // after the boot-up messages
        std::string const bytes = peer.hear();
        ASSERT_FALSE(bytes.empty());
        answer = raw_of(bytes);
    } while (answer.can_id > 0x700);
    EXPECT_EQ(answer.can_id, 0x582U);
    EXPECT_EQ(answer.data[0], 0x43);
    EXPECT_EQ(answer.data[4] + 256 * answer.data[5], 402) << "device type: CiA 402";
}

} // namespace gonio::sim
