// test_lockstep_link.cpp: the rule of virtual time (protocol/link.md) with a scripted host on a real socket.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lockstep_link.hpp"
#include "scripted_host.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t ms = 1000000;
constexpr std::int64_t patience_ns = 5000 * ms;

// What the firmware would read now.
Bytes read(Lockstep_link &link, std::uint32_t client) {
    Bytes bytes(1000);
    int const length = link.read(client, bytes.data(), bytes.size());
    bytes.resize(static_cast<std::size_t>(std::max(length, 0)));
    return bytes;
}

// A driver that has said HELLO at time 0, in place 0.
void greet(Lockstep_link &link, const Host &host) {
    ASSERT_TRUE(link.exchange(0, patience_ns));
    host.say(hello(gonio_Role_ROLE_DRIVER));
    ASSERT_TRUE(link.exchange(0, patience_ns));
    ASSERT_TRUE(link.deliver(0)) << "HELLO is taken at once";
    ASSERT_FALSE(read(link, 0).empty());
    ASSERT_TRUE(link.driver_present());
}

void firmware_sends(Lockstep_link &link, std::uint32_t sequence, std::int64_t now_ns) {
    Bytes const bytes = frame(GN_FRAME_EVENT, sequence, 0, {1, 2, 3});
    ASSERT_EQ(link.write(0, bytes.data(), bytes.size()), static_cast<int>(bytes.size()));
    link.frame_sent(0, sequence, now_ns);
}

} // namespace

TEST(LockstepLink, AnAnswerArrivesAMillisecondAfterWhatItAnswers) {
    Lockstep_link link("127.0.0.1", 0, false);
    Host const host(link);
    greet(link, host);
    EXPECT_EQ(link.barrier_ns(), INT64_MAX) << "nothing was sent, time is free";
    firmware_sends(link, 1, 100 * ms);
    firmware_sends(link, 2, 100 * ms + 500000);
    EXPECT_EQ(link.barrier_ns(), 101 * ms);
    Bytes const request = frame(GN_FRAME_REQUEST, 1, 1, {9});
    host.say(request);
    host.say(frame(GN_FRAME_IDLE, 0, 1));
    while (link.barrier_ns() == 101 * ms) {
        ASSERT_TRUE(link.exchange(101 * ms, patience_ns));
    }
    EXPECT_EQ(host.hear(), 2U * 23U);
    EXPECT_EQ(link.barrier_ns(), 101 * ms + 500000) << "frame 2 is still unanswered";
    EXPECT_EQ(link.next_delivery_ns(), 101 * ms);
    EXPECT_FALSE(link.deliver(101 * ms - 1));
    EXPECT_TRUE(link.deliver(101 * ms));
    Bytes expected = request;
    Bytes const idle = frame(GN_FRAME_IDLE, 0, 1);
    expected.insert(expected.end(), idle.begin(), idle.end());
    EXPECT_EQ(read(link, 0), expected);
    host.say(frame(GN_FRAME_IDLE, 0, 2));
    ASSERT_TRUE(link.exchange(101 * ms + 500000, patience_ns));
    EXPECT_EQ(link.barrier_ns(), INT64_MAX);
    EXPECT_EQ(link.next_delivery_ns(), 101 * ms + 500000);
}

TEST(LockstepLink, AFrameThatComesInPiecesIsDeliveredWhole) {
    Lockstep_link link("127.0.0.1", 0, false);
    Host const host(link);
    greet(link, host);
    Bytes const request = frame(GN_FRAME_REQUEST, 1, 0, Bytes(50, 7));
    host.say(Bytes(request.begin(), request.begin() + 13));
    ASSERT_TRUE(link.exchange(0, patience_ns));
    EXPECT_FALSE(link.deliver(INT64_MAX));
    host.say(Bytes(request.begin() + 13, request.end()));
    ASSERT_TRUE(link.exchange(0, patience_ns));
    EXPECT_TRUE(link.deliver(INT64_MAX));
    EXPECT_EQ(read(link, 0), request);
}

TEST(LockstepLink, AClosedSocketReleasesTheClockAndASilentHostToo) {
    Lockstep_link link("127.0.0.1", 0, false);
    Host host(link);
    greet(link, host);
    firmware_sends(link, 1, 0);
    EXPECT_EQ(link.barrier_ns(), ms);
    EXPECT_NE(link.waited_for().find("IDLE for frame 1"), std::string::npos) << link.waited_for();
    host.hang_up();
    while (link.driver_present()) {
        ASSERT_TRUE(link.exchange(ms, patience_ns));
    }
    EXPECT_EQ(link.barrier_ns(), INT64_MAX);
    std::uint8_t byte = 0;
    EXPECT_EQ(link.read(0, &byte, 1), -1);

    Host const next(link);
    greet(link, next);
    firmware_sends(link, 1, 0);
    link.silence_host();
    EXPECT_EQ(link.barrier_ns(), INT64_MAX);
    next.say(frame(GN_FRAME_REQUEST, 1, 1));
    EXPECT_FALSE(link.exchange(0, patience_ns));
    EXPECT_EQ(link.next_delivery_ns(), INT64_MAX);
}

TEST(LockstepLink, AVisitorHoldsNoClockAndAFourthClientIsTurnedAway) {
    Lockstep_link link("127.0.0.1", 0, false);
    EXPECT_NE(link.waited_for().find("a driver"), std::string::npos);
    Host const driver(link);
    greet(link, driver);
    Host const visitor(link);
    ASSERT_TRUE(link.exchange(0, patience_ns));
    visitor.say(hello(gonio_Role_ROLE_VISITOR));
    ASSERT_TRUE(link.exchange(7 * ms, patience_ns));
    EXPECT_EQ(link.next_delivery_ns(), 7 * ms);
    EXPECT_TRUE(link.deliver(7 * ms));
    link.frame_sent(1, 1, 7 * ms);
    EXPECT_EQ(link.barrier_ns(), INT64_MAX);
    Host const another_visitor(link);
    ASSERT_TRUE(link.exchange(0, patience_ns));
    Host const fourth(link);
    ASSERT_TRUE(link.exchange(0, patience_ns));
    EXPECT_EQ(fourth.hear(), 0U) << "closed";
}

TEST(LockstepLink, PacedModeDeliversAtOnceAndWaitsForNobody) {
    Lockstep_link link("127.0.0.1", 0, true);
    Host const host(link);
    greet(link, host);
    firmware_sends(link, 1, 50 * ms);
    EXPECT_EQ(link.barrier_ns(), INT64_MAX);
    host.say(frame(GN_FRAME_ALIVE, 0, 1));
    ASSERT_TRUE(link.exchange(60 * ms, patience_ns));
    EXPECT_EQ(link.next_delivery_ns(), 60 * ms);
}

TEST(LockstepLink, AnAddressThatCannotBeHadIsAnInputError) {
    EXPECT_THROW(Lockstep_link("300.0.0.1", 0, false), Input_error);
    Lockstep_link const first("127.0.0.1", 0, false);
    std::string const address = first.address();
    auto const port = static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
    EXPECT_THROW(Lockstep_link("127.0.0.1", port, false), Input_error);
}

} // namespace gonio::sim
