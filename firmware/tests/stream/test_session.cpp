// test_session.cpp: HELLO, refusals, replay after a reconnect, overflow, and what closes a connection.
#include <cstdio>

#include <gtest/gtest.h>

#include "bench_client.hpp"

namespace {

using gonio::test::Bench;
using gonio::test::Bytes;
using gonio::test::Client;

class Session : public testing::Test {
protected:
    Bench bench;

    Client driver(std::uint32_t number = 0) {
        Client client(bench, number);
        client.hello(gonio_Role_ROLE_DRIVER);
        bench.process();
        return client;
    }
    void log_event(std::uint32_t level, std::size_t text_length = 0) {
        gn_notice notice{};
        notice.as.event.which_body = gonio_Event_log_tag;
        notice.as.event.body.log.level = level;
        std::memset(notice.as.event.body.log.text, 'x', text_length);
        ASSERT_TRUE(gn_ring_push(&bench.shared->notices, &notice));
    }
};

TEST_F(Session, hello_is_answered_with_the_session) {
    Client client = driver();
    auto const frames = client.frames();
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_EQ(std::uint32_t{frames[0].header.sequence}, 0u);
    gonio_Hello const hello = frames[0].hello();
    EXPECT_EQ(hello.schema_hash, GN_SCHEMA_HASH);
    EXPECT_EQ(hello.session_id, Bench::session_id);
    EXPECT_STREQ(hello.refusal, "");
    EXPECT_EQ(bench.shared->host_heard_ns, bench.now_ns);
}

TEST_F(Session, a_schema_mismatch_names_both_hashes_and_closes) {
    Client client(bench, 0);
    client.hello(gonio_Role_ROLE_DRIVER, 0, 0, 0x0123456789abcdefu);
    bench.process();
    auto const frames = client.frames();
    ASSERT_EQ(frames.size(), 1u);
    char expected[160];
    std::snprintf(expected, sizeof expected,
                  "schema hashes differ: firmware %016llx, host 0123456789abcdef; install both from the same release",
                  static_cast<unsigned long long>(GN_SCHEMA_HASH));
    EXPECT_STREQ(frames[0].hello().refusal, expected);
    EXPECT_FALSE(client.wire().connected);
    EXPECT_EQ(bench.shared->host_heard_ns, 0);
}

TEST_F(Session, a_hello_that_breaks_off_still_learns_both_hashes) {
    Client client(bench, 0);
    Bytes payload = {0x09, 1, 0, 0, 0, 0, 0, 0, 0, 0x12, 0x7F}; // hash 1, then a string longer than the frame
    client.raw(client.sealed(GN_FRAME_HELLO, 0, payload));
    bench.process();
    auto const frames = client.frames();
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_NE(std::string(frames[0].hello().refusal).find("host 0000000000000001"), std::string::npos);
}

TEST_F(Session, one_drives_and_a_second_driver_is_refused) {
    Client first = driver(0);
    Client second = driver(1);
    auto const frames = second.frames();
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_STREQ(frames[0].hello().refusal, "another driver is connected; end it first, or connect as a visitor");
    EXPECT_FALSE(second.wire().connected);
    EXPECT_TRUE(first.wire().connected);
}

TEST_F(Session, any_frame_of_the_driver_is_heard_and_none_of_a_visitor) {
    Client client = driver(0);
    Client visitor(bench, 1);
    visitor.hello(gonio_Role_ROLE_VISITOR);
    std::int64_t const before_ns = bench.shared->host_heard_ns;
    bench.process();
    visitor.alive();
    bench.process();
    EXPECT_EQ(bench.shared->host_heard_ns, before_ns);
    client.alive();
    bench.process();
    EXPECT_EQ(bench.shared->host_heard_ns, bench.now_ns);
    client.wire().connected = false;
    std::int64_t const last_ns = bench.now_ns;
    bench.process();
    EXPECT_EQ(bench.shared->host_heard_ns, last_ns) << "the expiry runs on from the last word";
}

TEST_F(Session, what_was_not_received_is_replayed_after_a_reconnect) {
    Client client = driver();
    for (std::uint32_t level = 1; level <= 3; ++level) {
        log_event(level);
    }
    bench.process();
    EXPECT_EQ(client.frames_of(GN_FRAME_EVENT).size(), 3u); // the host will say that it has only the first of them
    client.wire().connected = false;
    log_event(4);
    bench.process();
    Client again(bench, 0);
    again.hello(gonio_Role_ROLE_DRIVER, Bench::session_id, 1);
    bench.process();
    auto const frames = again.frames();
    ASSERT_EQ(frames.size(), 4u);
    EXPECT_EQ(frames[0].hello().session_id, Bench::session_id);
    for (std::uint32_t i = 1; i < 4; ++i) {
        EXPECT_EQ(std::uint32_t{frames[i].header.sequence}, i + 1);
        EXPECT_EQ(frames[i].event().body.log.level, i + 1);
    }
}

TEST_F(Session, a_driver_that_reconnects_takes_over_from_its_dead_connection) {
    Client client = driver(0);
    Client again(bench, 1);
    again.hello(gonio_Role_ROLE_DRIVER, Bench::session_id, 0);
    bench.process();
    EXPECT_FALSE(client.wire().connected);
    ASSERT_EQ(again.frames().size(), 1u);
    log_event(5);
    bench.process();
    EXPECT_EQ(again.frames_of(GN_FRAME_EVENT).size(), 1u);
}

TEST_F(Session, a_new_session_begins_at_one_and_has_another_id) {
    Client client = driver();
    log_event(1);
    bench.process();
    client.wire().connected = false;
    log_event(2);
    bench.process();
    Client again = driver();
    log_event(3);
    bench.process();
    auto const frames = again.frames();
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_EQ(frames[0].hello().session_id, Bench::session_id + 1);
    EXPECT_EQ(std::uint32_t{frames[1].header.sequence}, 1u);
    EXPECT_EQ(frames[1].event().body.log.level, 3u);
}

TEST_F(Session, a_replay_of_frames_that_never_were_is_refused) {
    Client client = driver();
    client.wire().connected = false;
    bench.process();
    Client again(bench, 0);
    again.hello(gonio_Role_ROLE_DRIVER, Bench::session_id, 9);
    bench.process();
    EXPECT_STREQ(again.frames().at(0).hello().refusal,
                 "session 0000000000001000 never had a frame 9; begin a new session");
}

TEST_F(Session, overflow_is_a_jump_in_the_sequence_and_a_counted_gap) {
    Client client = driver();
    client.frames();
    client.wire().room = 0; // the host reads no more
    std::uint32_t made = 0;
    for (; made < 9000; ++made) {
        log_event(made, 150);
        bench.process(1000);
    }
    client.wire().room = SIZE_MAX;
    bench.process();
    auto const frames = client.frames();
    std::uint32_t jumps = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        std::uint32_t const before = i == 0 ? 0 : frames[i - 1].header.sequence;
        jumps += frames[i].header.sequence - before - 1;
        EXPECT_EQ(frames[i].event().body.log.level, frames[i].header.sequence - 1);
    }
    EXPECT_EQ(frames.back().header.sequence, made);
    EXPECT_GT(jumps, 1000u);
    bench.process(2000000000);
    gonio_Event const counters = client.frames_of(GN_FRAME_EVENT).at(0).event();
    ASSERT_EQ(counters.which_body, gonio_Event_counters_tag);
    EXPECT_EQ(counters.body.counters.link_gap_frames, jumps);
}

TEST_F(Session, acknowledged_frames_make_room) {
    Client client = driver();
    for (std::uint32_t made = 0; made < 9000; ++made) {
        log_event(made, 150);
        bench.process(1000);
        client.frames();
        client.alive();
    }
    client.wire().connected = false;
    bench.process();
    Client again(bench, 0);
    again.hello(gonio_Role_ROLE_DRIVER, Bench::session_id, client.acknowledged);
    bench.process();
    EXPECT_EQ(again.frames().size(), 1u);
}

TEST_F(Session, a_crc_failure_closes_the_session) {
    Client client = driver();
    Bytes bytes = client.sealed(GN_FRAME_ALIVE, 0, {});
    bytes[17] ^= 4;
    client.raw(bytes);
    bench.process();
    EXPECT_FALSE(client.wire().connected);
    ASSERT_FALSE(bench.log.empty());
    EXPECT_EQ(bench.log.back(), "link: client 0 dismissed: bad CRC");
}

TEST_F(Session, what_breaks_the_protocol_closes_the_connection) {
    Client early(bench, 0);
    early.alive();
    bench.process();
    EXPECT_FALSE(early.wire().connected) << "no HELLO first";

    Client jumping = driver();
    jumping.request(1, gonio_Request_boot_tag);
    jumping.sequence += 1;
    jumping.request(2, gonio_Request_boot_tag);
    bench.process();
    EXPECT_FALSE(jumping.wire().connected) << "frame numbers jump";
    EXPECT_EQ(gn_ring_fill(&bench.shared->commands), 1u);

    Client greedy = driver();
    greedy.acknowledged = 1000;
    greedy.alive();
    bench.process();
    EXPECT_FALSE(greedy.wire().connected) << "acknowledges what was not sent";

    Client visitor(bench, 0);
    visitor.hello(gonio_Role_ROLE_VISITOR);
    visitor.knots(1, 0, 1);
    bench.process();
    EXPECT_FALSE(visitor.wire().connected) << "knots of a visitor";

    Client nobody(bench, 0);
    nobody.hello(gonio_Role_ROLE_UNSPECIFIED);
    bench.process();
    EXPECT_STREQ(nobody.frames().at(0).hello().refusal, "HELLO names no role; say DRIVER or VISITOR");
}

TEST_F(Session, frames_come_whole_through_a_link_that_takes_a_few_bytes_at_a_time) {
    Client client = driver();
    client.frames();
    client.wire().room = 7;
    for (std::uint32_t level = 1; level <= 4; ++level) {
        log_event(level, 40);
    }
    for (int i = 0; i < 60; ++i) {
        bench.process(100);
    }
    auto const frames = client.frames();
    ASSERT_EQ(frames.size(), 4u);
    EXPECT_EQ(frames[3].event().body.log.level, 4u);
}

} // namespace
