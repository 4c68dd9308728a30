// test_stream.cpp: strobes, packets and poses in; blocks with times, gap flags and counters out.
#include <cmath>

#include <gtest/gtest.h>

#include "bench_client.hpp"

namespace {

using gonio::test::Bench;
using gonio::test::Bytes;
using gonio::test::Client;

// A digitiser of 1 kHz with a strobe every 10 samples, that started at `start_ns`.
struct Source {
    Bench &bench;
    std::int64_t start_ns;
    std::uint32_t next_sample = 0;
    std::uint16_t next_packet = 0;
    std::uint32_t edge_number = 0;

    void packet(bool lose = false) {
        gn_digitiser_packet const header = {0x4744, next_packet++, next_sample, 50, 0};
        Bytes bytes(sizeof header + std::size_t{50} * GN_SAMPLE_SIZE);
        std::memcpy(bytes.data(), &header, sizeof header);
        for (std::uint32_t i = 0; i < 50; ++i) {
            gn_sample const sample = {static_cast<std::int32_t>(next_sample + i), -5, 100000, 2512, 0};
            std::memcpy(bytes.data() + sizeof header + std::size_t{i} * GN_SAMPLE_SIZE, &sample, sizeof sample);
        }
        next_sample += 50;
        if (!lose) {
            bench.packets.push_back(bytes);
        }
    }
    void strobe(std::int64_t number, std::int64_t late_ns) {
        std::int64_t const up_ns = start_ns + number * 10000000;
        std::int64_t const width_ns = number % 64 == 0 ? 5000000 : 2500000;
        for (bool const rising : {true, false}) {
            gn_edge const edge = {GN_LINE_STROBE, ++edge_number, rising, up_ns + late_ns + (rising ? 0 : width_ns)};
            ASSERT_TRUE(gn_ring_push(&bench.shared->strobes, &edge));
        }
    }
    // 50 ms: five strobes and a packet, which arrives as soon as it is full.
    void run(bool lose = false) {
        for (std::int64_t i = 0; i < 5; ++i) {
            strobe(next_sample / 10 + i, (next_sample / 10 + i) % 3 == 0 ? 0 : 40000);
        }
        packet(lose);
        bench.process(start_ns + std::int64_t{next_sample} * 1000000 - bench.now_ns);
    }
};

class Stream : public testing::Test {
protected:
    Bench bench;
    Client driver{bench, 0};

    void SetUp() override {
        driver.hello(gonio_Role_ROLE_DRIVER);
        gonio_Request request = gonio_Request_init_zero;
        request.id = 1;
        request.which_body = gonio_Request_configure_tag;
        request.body.configure.axis_count = 4;
        request.body.configure.sample_period_us = 1000;
        request.body.configure.samples_per_strobe = 10;
        request.body.configure.clock_settle_ms = 2000;
        request.body.configure.edge_tolerance_percent = 25;
        driver.request(request);
        bench.process();
        gn_notice notice{};
        notice.is_reply = true;
        notice.as.reply.id = 1;
        ASSERT_TRUE(gn_ring_push(&bench.shared->notices, &notice));
        bench.process();
        driver.acquire(2, true);
        bench.process();
        driver.frames();
    }
    Source source() { return {bench, bench.now_ns + 1000000}; }
};

TEST_F(Stream, samples_come_in_blocks_with_the_fitted_time_once_the_clock_has_settled) {
    Source digitiser = source();
    for (int i = 0; i < 60; ++i) {
        digitiser.run();
    }
    auto const frames = driver.frames_of(GN_FRAME_SAMPLES);
    ASSERT_EQ(frames.size(), 30u);
    for (std::uint32_t i = 0; i < frames.size(); ++i) {
        auto const block = frames[i].record<gn_sample_block>();
        EXPECT_EQ(std::uint32_t{block.block}, i);
        EXPECT_EQ(std::uint64_t{block.first_sample}, 100u * i);
        EXPECT_EQ(std::uint32_t{block.count}, 100u);
        ASSERT_EQ(frames[i].payload.size(), GN_SAMPLE_BLOCK_SIZE + 100 * GN_SAMPLE_SIZE);
        auto const last = frames[i].record<gn_sample>(GN_SAMPLE_BLOCK_SIZE + 99 * GN_SAMPLE_SIZE);
        EXPECT_EQ(std::int32_t{last.high_counts}, static_cast<std::int32_t>(100 * i + 99));
        std::int64_t const truth_ns = digitiser.start_ns + 100000000 * std::int64_t{i};
        if (i < 20) { // the first 2 s: when the block's first packet arrived, and a flag
            EXPECT_EQ(std::uint32_t{block.flags}, GN_SAMPLE_BLOCK_CLOCK_UNSETTLED);
            EXPECT_EQ(std::uint32_t{block.window}, 0u);
            EXPECT_EQ(std::int64_t{block.first_time_ns}, truth_ns + 50000000);
        } else {
            EXPECT_EQ(std::uint32_t{block.flags}, 0u);
            EXPECT_EQ(std::int64_t{block.first_time_ns}, truth_ns);
            EXPECT_EQ(double{block.period_ns}, 1e6);
            EXPECT_EQ(std::uint32_t{block.window}, 10 * (i + 1));
            EXPECT_NEAR(block.residual_ns, 40e3 * 2 / 3, 200.0);
        }
    }
    EXPECT_EQ(bench.shared->clock_locked, 1u);
}

TEST_F(Stream, a_lost_packet_ends_the_block_and_the_next_says_so) {
    Source digitiser = source();
    digitiser.run();
    digitiser.run(true);
    digitiser.run();
    digitiser.run();
    auto const frames = driver.frames_of(GN_FRAME_SAMPLES);
    ASSERT_EQ(frames.size(), 2u);
    auto const before = frames[0].record<gn_sample_block>();
    auto const after = frames[1].record<gn_sample_block>();
    EXPECT_EQ(std::uint32_t{before.count}, 50u);
    EXPECT_EQ(before.flags & GN_SAMPLE_BLOCK_GAP_BEFORE, 0u);
    EXPECT_EQ(std::uint64_t{after.first_sample}, 100u);
    EXPECT_EQ(after.flags & GN_SAMPLE_BLOCK_GAP_BEFORE, GN_SAMPLE_BLOCK_GAP_BEFORE);
    EXPECT_EQ(std::uint32_t{after.samples_lost}, 50u);
}

TEST_F(Stream, a_rejected_strobe_flags_one_block) {
    Source digitiser = source();
    for (int i = 0; i < 44; ++i) {
        digitiser.run();
    }
    driver.frames();
    gn_edge const glitch = {GN_LINE_STROBE, ++digitiser.edge_number, true, bench.now_ns - 5000000};
    ASSERT_TRUE(gn_ring_push(&bench.shared->strobes, &glitch));
    for (int i = 0; i < 4; ++i) {
        digitiser.run();
    }
    auto const frames = driver.frames_of(GN_FRAME_SAMPLES);
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_EQ(frames[0].record<gn_sample_block>().flags, GN_SAMPLE_BLOCK_STROBE_REJECTED);
    EXPECT_EQ(frames[1].record<gn_sample_block>().flags, 0u);
    EXPECT_EQ(frames[1].record<gn_sample_block>().strobes_lost, 1u);
}

TEST_F(Stream, acquire_off_sends_what_is_left_then_counters_then_the_reply) {
    Source digitiser = source();
    digitiser.run();
    digitiser.packet();
    digitiser.packet(); // still in the digitiser's hands
    driver.frames();
    driver.acquire(3, false);
    bench.process();
    auto const frames = driver.frames();
    ASSERT_EQ(frames.size(), 4u);
    EXPECT_EQ(frames[0].record<gn_sample_block>().count, 100u);
    EXPECT_EQ(frames[1].record<gn_sample_block>().count, 50u);
    gonio_Event const counters = frames[2].event();
    ASSERT_EQ(counters.which_body, gonio_Event_counters_tag);
    EXPECT_EQ(counters.body.counters.samples, 150u);
    EXPECT_EQ(counters.body.counters.strobes, 5u);
    EXPECT_EQ(frames[3].reply().code, gonio_ReplyCode_REPLY_OK);
    EXPECT_FALSE(bench.digitising);
    EXPECT_EQ(bench.shared->acquiring, 0u);
}

TEST_F(Stream, a_second_acquisition_begins_at_sample_zero) {
    Source first = source();
    first.run();
    driver.acquire(3, false);
    bench.process();
    driver.acquire(4, true);
    bench.process();
    driver.frames();
    Source second = source();
    second.edge_number = first.edge_number;
    for (int i = 0; i < 44; ++i) {
        second.run();
    }
    auto const frames = driver.frames_of(GN_FRAME_SAMPLES);
    ASSERT_EQ(frames.size(), 22u);
    EXPECT_EQ(std::uint64_t{frames[0].record<gn_sample_block>().first_sample}, 0u);
    EXPECT_EQ(std::int64_t{frames[21].record<gn_sample_block>().first_time_ns}, second.start_ns + 2100000000);
}

TEST_F(Stream, an_unplugged_digitiser_is_a_fault_and_stops_the_motion) {
    Source digitiser = source();
    digitiser.run();
    driver.frames();
    bench.digitiser_there = false;
    bench.process();
    auto const frames = driver.frames();
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_EQ(frames[0].record<gn_sample_block>().count, 50u);
    EXPECT_EQ(frames[1].event().body.fault.code, gonio_FaultCode_FAULT_DIGITISER);
    EXPECT_EQ(bench.shared->stop_requested, 1u);
    bench.process();
    EXPECT_TRUE(driver.frames().empty()) << "one fault for one cause";
}

TEST_F(Stream, a_strobe_line_that_falls_silent_is_a_fault_after_twice_the_settling_time) {
    Source digitiser = source();
    while (digitiser.next_sample < 2500) {
        digitiser.run();
    }
    std::int64_t const last_strobe_ns = digitiser.start_ns + 2490000000;
    auto const run_on_until = [&](std::int64_t time_ns) { // packets, but no strobes
        while (bench.now_ns < time_ns) {
            digitiser.packet();
            bench.process(50000000);
        }
    };
    run_on_until(last_strobe_ns + 3900000000);
    for (const auto &frame : driver.frames_of(GN_FRAME_EVENT)) {
        EXPECT_NE(frame.event().which_body, gonio_Event_fault_tag);
    }
    EXPECT_EQ(bench.shared->stop_requested, 0u);
    run_on_until(last_strobe_ns + 4100000000);
    std::string sentence;
    for (const auto &frame : driver.frames_of(GN_FRAME_EVENT)) {
        if (frame.event().which_body == gonio_Event_fault_tag) {
            EXPECT_EQ(frame.event().body.fault.code, gonio_FaultCode_FAULT_DIGITISER);
            EXPECT_TRUE(sentence.empty()) << "one fault for one cause";
            sentence = frame.event().body.fault.sentence;
        }
    }
    EXPECT_NE(sentence.find("strobe"), std::string::npos) << sentence;
    EXPECT_EQ(bench.shared->stop_requested, 1u);
    EXPECT_EQ(bench.shared->acquiring, 0u);
}

TEST_F(Stream, poses_come_in_blocks_of_fifty_or_after_100_ms) {
    for (std::uint32_t i = 1; i <= 60; ++i) {
        gn_pose const pose = {.sync_time_ns = 2000000 * std::int64_t{i},
                              .sync_number = i,
                              .position_counts = {1, -2, 3, static_cast<std::int32_t>(i)},
                              .valid = 15,
                              .flags = 0,
                              .reserved = 0};
        ASSERT_TRUE(gn_ring_push(&bench.shared->poses, &pose));
    }
    bench.process();
    auto const full = driver.frames_of(GN_FRAME_POSES);
    ASSERT_EQ(full.size(), 1u);
    EXPECT_EQ(full[0].record<gn_pose_block>().count, 50u);
    EXPECT_EQ(full[0].record<gn_pose_block>().axis_count, 4u);
    EXPECT_EQ(full[0].record<gn_pose>(GN_POSE_BLOCK_SIZE + 49 * GN_POSE_SIZE).sync_number, 50u);
    bench.process(99000000);
    EXPECT_TRUE(driver.frames_of(GN_FRAME_POSES).empty());
    bench.process(1000000);
    auto const rest = driver.frames_of(GN_FRAME_POSES);
    ASSERT_EQ(rest.size(), 1u);
    EXPECT_EQ(rest[0].record<gn_pose_block>().count, 10u);
    EXPECT_EQ(rest[0].record<gn_pose_block>().block, 1u);
}

TEST_F(Stream, pose_blocks_say_how_sure_the_interface_is_of_its_stamps) {
    bench.shared->sync_stamp_sigma_us = 12.5F;
    gn_pose const pose{};
    ASSERT_TRUE(gn_ring_push(&bench.shared->poses, &pose));
    bench.process();
    bench.process(100000000);
    auto const blocks = driver.frames_of(GN_FRAME_POSES);
    ASSERT_EQ(blocks.size(), 1u);
    EXPECT_EQ(float{blocks[0].record<gn_pose_block>().sync_stamp_sigma_us}, 12.5F);
}

TEST_F(Stream, latency_of_each_thread_that_is_measured_comes_beside_the_counters) {
    for (int i = 0; i < 3; ++i) {
        gn_latency_record(&bench.shared->stream_latency, 5500); // 5 us late: bin 3, less than 8 us
    }
    bench.process(1000000000);
    auto const events = driver.frames_of(GN_FRAME_EVENT);
    ASSERT_EQ(events.size(), 2u) << "counters, and the latency of one thread";
    gonio_Event const event = events[1].event();
    ASSERT_EQ(event.which_body, gonio_Event_latency_tag);
    EXPECT_EQ(event.time_ns, bench.now_ns);
    EXPECT_EQ(event.body.latency.thread, gonio_Thread_THREAD_STREAM);
    EXPECT_EQ(event.body.latency.wakeups, 3u);
    EXPECT_EQ(event.body.latency.max_us, 5u);
    ASSERT_EQ(event.body.latency.bins_count, GN_LATENCY_BINS);
    EXPECT_EQ(event.body.latency.bins[3], 3u);
    gn_latency_record(&bench.shared->motion_latency, 0);
    bench.process(1000000000);
    EXPECT_EQ(driver.frames_of(GN_FRAME_EVENT).size(), 3u);
}

TEST_F(Stream, counters_come_every_second_with_motions_own) {
    gn_motion_counters &motion = bench.shared->counters;
    motion.tpdo_late = 3;
    motion.can_setpoints_dropped = 4;
    motion.can_bus_offs = 5;
    motion.clock_steps = 6;
    motion.edges_lost = 7;
    motion.cycles_missed = 8;
    bench.process(1000000000);
    auto const events = driver.frames_of(GN_FRAME_EVENT);
    ASSERT_EQ(events.size(), 1u);
    gonio_Counters const counters = events[0].event().body.counters;
    EXPECT_EQ(counters.tpdo_late, 3u);
    EXPECT_EQ(counters.can_setpoints_dropped, 4u);
    EXPECT_EQ(counters.can_bus_offs, 5u);
    EXPECT_EQ(counters.clock_steps, 6u);
    EXPECT_EQ(counters.edges_lost, 7u);
    EXPECT_EQ(counters.cycles_missed, 8u);
    EXPECT_EQ(events[0].event().time_ns, bench.now_ns);
    bench.process(999000000);
    EXPECT_TRUE(driver.frames_of(GN_FRAME_EVENT).empty());
}

TEST_F(Stream, a_new_driver_finds_acquisition_off_and_none_of_the_old_samples) {
    Source digitiser = source();
    digitiser.run();
    driver.wire().connected = false;
    bench.process();
    digitiser.packet();
    Client again(bench, 0);
    again.hello(gonio_Role_ROLE_DRIVER);
    bench.process();
    EXPECT_FALSE(bench.digitising);
    EXPECT_EQ(again.frames().size(), 1u);
    bench.process(200000000);
    EXPECT_TRUE(again.frames().empty());
}

} // namespace
