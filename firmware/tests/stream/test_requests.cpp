// test_requests.cpp: who may ask what, what is answered here, what goes to motion, and knots held to their credit.
#include <gtest/gtest.h>

#include <algorithm>

#include "bench_client.hpp"

namespace {

using gonio::test::Bench;
using gonio::test::Client;

class Requests : public testing::Test {
protected:
    Bench bench;
    Client driver{bench, 0};

    void SetUp() override {
        driver.hello(gonio_Role_ROLE_DRIVER);
        bench.process();
        driver.frames();
    }
    gn_command command() {
        gn_command command{};
        EXPECT_TRUE(gn_ring_pop(&bench.shared->commands, &command));
        return command;
    }
    void motion_replies(const gonio_Reply &reply) {
        gn_notice notice{};
        notice.is_reply = true;
        notice.as.reply = reply;
        ASSERT_TRUE(gn_ring_push(&bench.shared->notices, &notice));
        bench.process();
    }
    void motion_replies(std::uint32_t id, gonio_ReplyCode code) {
        gonio_Reply reply = gonio_Reply_init_zero;
        reply.id = id;
        reply.code = code;
        motion_replies(reply);
    }
    void motion_grants(std::uint32_t path_id, std::uint32_t credit) {
        gn_notice notice{};
        notice.as.event.which_body = gonio_Event_status_tag;
        notice.as.event.body.status.path_id = path_id;
        notice.as.event.body.status.knot_credit = credit;
        ASSERT_TRUE(gn_ring_push(&bench.shared->notices, &notice));
        bench.process();
    }
    void ask_configure(std::uint32_t id, std::uint32_t sample_period_us = 1000) {
        gonio_Request request = gonio_Request_init_zero;
        request.id = id;
        request.which_body = gonio_Request_configure_tag;
        request.body.configure.sample_period_us = sample_period_us;
        request.body.configure.samples_per_strobe = 10;
        request.body.configure.clock_settle_ms = 2000;
        request.body.configure.edge_tolerance_percent = 25;
        driver.request(request);
        bench.process();
    }
    gonio_Reply reply_to(Client &client) {
        auto const frames = client.frames_of(GN_FRAME_REPLY);
        EXPECT_EQ(frames.size(), 1u);
        return frames.empty() ? gonio_Reply{} : frames[0].reply();
    }
};

TEST_F(Requests, motions_requests_reach_it_whole_and_its_reply_comes_back) {
    gonio_Request request = gonio_Request_init_zero;
    request.id = 12;
    request.which_body = gonio_Request_motion_begin_tag;
    request.body.motion_begin.path_id = 3;
    request.body.motion_begin.knot_count = 400;
    driver.request(request);
    bench.process();
    gn_command const received = command();
    EXPECT_EQ(received.request.id, 12u);
    EXPECT_EQ(received.request.body.motion_begin.knot_count, 400u);
    EXPECT_TRUE(driver.frames_of(GN_FRAME_REPLY).empty()) << "only motion can answer";
    motion_replies(12, gonio_ReplyCode_REPLY_ACCEPTED);
    EXPECT_EQ(reply_to(driver).code, gonio_ReplyCode_REPLY_ACCEPTED);
}

TEST_F(Requests, stop_is_taken_from_anyone_and_a_visitor_may_do_nothing_else) {
    Client visitor(bench, 1);
    visitor.hello(gonio_Role_ROLE_VISITOR);
    visitor.request(1, gonio_Request_boot_tag);
    visitor.request(2, gonio_Request_stop_tag);
    visitor.request(3, gonio_Request_acquire_tag);
    bench.process();
    auto const replies = visitor.frames_of(GN_FRAME_REPLY);
    ASSERT_EQ(replies.size(), 3u);
    EXPECT_EQ(replies[0].reply().code, gonio_ReplyCode_REPLY_NOT_DRIVER);
    EXPECT_EQ(replies[1].reply().code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(replies[2].reply().code, gonio_ReplyCode_REPLY_NOT_DRIVER);
    EXPECT_EQ(replies[2].reply().id, 3u);
    EXPECT_EQ(std::uint32_t{replies[2].header.sequence}, 3u);
    EXPECT_EQ(gn_ring_fill(&bench.shared->commands), 0u);
    EXPECT_EQ(bench.shared->stop_requested, 1u);
    auto const told = driver.frames_of(GN_FRAME_EVENT);
    EXPECT_EQ(std::count_if(told.begin(), told.end(),
                            [](auto const &frame) { return frame.event().which_body == gonio_Event_stop_tag; }),
              1);
    driver.request(1, gonio_Request_stop_tag);
    bench.process();
    EXPECT_EQ(bench.shared->stop_requested, 2u);
}

TEST_F(Requests, info_goes_to_the_one_who_asked_with_what_the_stream_side_knows) {
    Client visitor(bench, 1);
    visitor.hello(gonio_Role_ROLE_VISITOR);
    bench.shared->kernel = "Linux 6.1.0-rt aarch64";
    bench.shared->realtime = true;
    visitor.request(7, gonio_Request_get_info_tag);
    driver.request(7, gonio_Request_get_info_tag);
    bench.process();
    visitor.frames();
    for (int i = 0; i < 2; ++i) {
        gonio_Reply reply = gonio_Reply_init_zero;
        reply.id = command().request.id;
        reply.which_body = gonio_Reply_info_tag;
        reply.body.info.axis_count = reply.id == 7 ? 4 : 3;
        motion_replies(reply);
    }
    gonio_Reply const visitors = reply_to(visitor);
    gonio_Reply const drivers = reply_to(driver);
    EXPECT_EQ(visitors.id, 7u);
    EXPECT_EQ(visitors.body.info.axis_count, 3u);
    EXPECT_EQ(drivers.id, 7u);
    EXPECT_EQ(drivers.body.info.axis_count, 4u);
    EXPECT_STREQ(visitors.body.info.device, "bench");
    EXPECT_STREQ(visitors.body.info.kernel, "Linux 6.1.0-rt aarch64");
    EXPECT_TRUE(visitors.body.info.realtime);
    EXPECT_TRUE(visitors.body.info.driver_connected);
    EXPECT_NE(std::string(visitors.body.info.firmware), "");
}

TEST_F(Requests, a_full_command_ring_refuses) {
    for (std::uint32_t id = 1; id <= GN_COMMAND_CAPACITY + 1; ++id) {
        driver.request(id, gonio_Request_clear_fault_tag);
    }
    bench.process();
    gonio_Reply const reply = reply_to(driver);
    EXPECT_EQ(reply.id, GN_COMMAND_CAPACITY + 1);
    EXPECT_EQ(reply.code, gonio_ReplyCode_REPLY_REFUSED);
}

TEST_F(Requests, what_cannot_be_decoded_is_invalid) {
    driver.raw(driver.sealed(GN_FRAME_REQUEST, ++driver.sequence, {0x08, 0x05, 0x12, 0x7F}));
    driver.raw(driver.sealed(GN_FRAME_REQUEST, ++driver.sequence, {0x08, 0x06}));
    bench.process();
    auto const replies = driver.frames_of(GN_FRAME_REPLY);
    ASSERT_EQ(replies.size(), 2u);
    EXPECT_EQ(replies[0].reply().id, 5u);
    EXPECT_EQ(replies[0].reply().code, gonio_ReplyCode_REPLY_INVALID);
    EXPECT_EQ(replies[1].reply().id, 6u);
    EXPECT_EQ(replies[1].reply().code, gonio_ReplyCode_REPLY_INVALID);
}

TEST_F(Requests, acquire_needs_a_configuration_that_motion_has_accepted) {
    driver.acquire(1, true);
    bench.process();
    EXPECT_EQ(reply_to(driver).code, gonio_ReplyCode_REPLY_REFUSED);
    ask_configure(2);
    motion_replies(2, gonio_ReplyCode_REPLY_REFUSED);
    driver.frames();
    driver.acquire(3, true);
    bench.process();
    EXPECT_EQ(reply_to(driver).code, gonio_ReplyCode_REPLY_REFUSED);
    ask_configure(4);
    motion_replies(4, gonio_ReplyCode_REPLY_OK);
    driver.frames();
    driver.acquire(5, true);
    bench.process();
    EXPECT_EQ(reply_to(driver).code, gonio_ReplyCode_REPLY_OK);
    EXPECT_TRUE(bench.digitising);
    EXPECT_EQ(bench.shared->acquiring, 1u);
    ask_configure(6);
    EXPECT_EQ(reply_to(driver).code, gonio_ReplyCode_REPLY_REFUSED) << "not while it acquires";
}

TEST_F(Requests, a_sampling_that_cannot_work_never_reaches_motion) {
    ask_configure(1, 0);
    gonio_Reply const reply = reply_to(driver);
    EXPECT_EQ(reply.code, gonio_ReplyCode_REPLY_INVALID);
    EXPECT_STREQ(reply.text, "Configure.sample_period_us must be 1 to 1000000");
    EXPECT_EQ(gn_ring_fill(&bench.shared->commands), 0u);
}

TEST_F(Requests, a_digitiser_that_is_not_there_is_a_fault) {
    ask_configure(1);
    motion_replies(1, gonio_ReplyCode_REPLY_OK);
    driver.frames();
    bench.digitiser_there = false;
    driver.acquire(2, true);
    bench.process();
    EXPECT_EQ(reply_to(driver).code, gonio_ReplyCode_REPLY_FAULT);
}

TEST_F(Requests, knots_within_the_credit_reach_motion_in_order) {
    motion_grants(5, 8);
    driver.knots(5, 0, 3);
    driver.knots(5, 3, 5);
    bench.process();
    ASSERT_EQ(gn_ring_fill(&bench.shared->knots), 8u);
    for (std::uint32_t i = 0; i < 8; ++i) {
        gn_knot_item item{};
        gn_ring_pop(&bench.shared->knots, &item);
        EXPECT_EQ(item.path_id, 5u);
        EXPECT_EQ(item.number, i);
        EXPECT_EQ(std::int64_t{item.knot.time_ns}, 1000 * i);
    }
    EXPECT_EQ(bench.shared->stop_requested, 0u);
}

TEST_F(Requests, knots_beyond_the_credit_are_refused_and_the_path_is_stopped) {
    motion_grants(5, 8);
    driver.frames();
    driver.knots(5, 4, 5);
    bench.process();
    EXPECT_EQ(gn_ring_fill(&bench.shared->knots), 0u);
    EXPECT_EQ(bench.shared->stop_requested, 1u);
    auto const events = driver.frames_of(GN_FRAME_EVENT);
    ASSERT_EQ(events.size(), 1u);
    EXPECT_STREQ(events[0].event().body.log.text,
                 "path 5: knot 8 is beyond the credit of 8 knots; the path is stopped, wait for Status");
}

TEST_F(Requests, knots_of_another_path_or_of_a_wrong_size_are_refused) {
    motion_grants(5, 8);
    driver.knots(6, 0, 1);
    bench.process();
    EXPECT_EQ(bench.shared->stop_requested, 1u);
    gonio::test::Bytes payload(GN_KNOT_BLOCK_SIZE + GN_KNOT_SIZE - 1);
    gn_knot_block const block = {5, 0, 1, 0};
    std::memcpy(payload.data(), &block, sizeof block);
    driver.raw(driver.sealed(GN_FRAME_KNOTS, ++driver.sequence, payload));
    driver.raw(driver.sealed(GN_FRAME_KNOTS, ++driver.sequence, {1, 2, 3}));
    bench.process();
    EXPECT_EQ(bench.shared->stop_requested, 3u);
    EXPECT_EQ(gn_ring_fill(&bench.shared->knots), 0u);
}

TEST_F(Requests, credit_once_granted_stays_for_knots_on_their_way) {
    motion_grants(5, 8);
    motion_grants(5, 0); // the path has ended
    driver.knots(5, 0, 8);
    bench.process();
    EXPECT_EQ(bench.shared->stop_requested, 0u);
    motion_grants(6, 2);
    driver.knots(6, 0, 3);
    bench.process();
    EXPECT_EQ(bench.shared->stop_requested, 1u);
}

} // namespace
