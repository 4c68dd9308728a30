// test_can_bus.cpp: arbitration, bit times and fates of frames, against ISO 11898-1 worked out bit by bit.
#include <gtest/gtest.h>

#include "bench.hpp"
#include "can_bits.hpp"

namespace gonio::sim {
namespace {

// The standard's rules, bit by bit, as slowly as they are written.
std::int64_t bits_by_the_book(const gn_can_frame &frame) {
    std::vector<int> bits{0};
    for (int k = 10; k >= 0; --k) {
        bits.push_back(static_cast<int>(frame.id >> k & 1U));
    }
    bits.insert(bits.end(), {0, 0, 0});
    for (int k = 3; k >= 0; --k) {
        bits.push_back(frame.length >> k & 1);
    }
    for (unsigned byte = 0; byte < frame.length; ++byte) {
        for (int k = 7; k >= 0; --k) {
            bits.push_back(frame.data[byte] >> k & 1);
        }
    }
    unsigned crc = 0;
    for (const int bit : bits) {
        const bool next = (bit != 0) != ((crc & 0x4000U) != 0);
        crc = (crc << 1U) & 0x7FFFU;
        crc ^= next ? 0x4599U : 0U;
    }
    for (int k = 14; k >= 0; --k) {
        bits.push_back(static_cast<int>(crc >> k & 1U));
    }
    std::int64_t total = 0;
    int last = -1;
    int run = 0;
    for (const int bit : bits) {
        ++total;
        run = bit == last ? run + 1 : 1;
        last = bit;
        if (run == 5) {
            ++total;
            last = 1 - bit;
            run = 1;
        }
    }
    return total + 1 + 2 + 7;
}

TEST(Can_bits, agree_with_the_standard_bit_by_bit) {
    std::uint32_t random = 12345;
    for (int k = 0; k < 20000; ++k) {
        random = random * 1664525U + 1013904223U;
        gn_can_frame frame{};
        frame.id = random >> 20U & 0x7FFU;
        frame.length = static_cast<std::uint8_t>((random >> 8U) % 9U);
        for (unsigned byte = 0; byte < frame.length; ++byte) {
            random = random * 1664525U + 1013904223U;
            // Many long runs of equal bits.
            frame.data[byte] = (random >> 30U) == 0 ? static_cast<std::uint8_t>(random >> 16U)
                                                    : ((random >> 29U & 1U) != 0 ? 0xFF : 0x00);
        }
        ASSERT_EQ(static_cast<std::int64_t>(can_frame_bits(frame)), bits_by_the_book(frame))
            << "id " << frame.id << " length " << +frame.length;
    }
}

TEST(Can_bus, the_lowest_identifier_goes_first_and_frames_follow_after_the_intermission) {
    Scheduler scheduler;
    Can_bus bus(scheduler, 1'000'000);
    Recorder a;
    Recorder b;
    const int first = bus.attach(a);
    const int second = bus.attach(b);
    bus.send(first, make_frame(0x300, {1}));
    bus.send(second, make_frame(0x181, {2}));
    bus.send(first, make_frame(0x181, {3}));
    bus.send(second, make_frame(0x080, {}));
    while (scheduler.run_one(ns_per_ms)) {
    }
    ASSERT_EQ(b.frames.size(), 4U);
    const std::vector<std::uint32_t> ids{b.frames[0].id, b.frames[1].id, b.frames[2].id, b.frames[3].id};
    EXPECT_EQ(ids, (std::vector<std::uint32_t>{0x080, 0x181, 0x181, 0x300}));
    EXPECT_EQ(b.frames[1].data[0], 2); // of equal identifiers the older
    EXPECT_TRUE(b.frames[0].own_echo);
    EXPECT_FALSE(a.frames[0].own_echo);
    EXPECT_TRUE(a.frames[2].own_echo);

    std::int64_t expected_ns = 0;
    for (const gn_can_frame &frame : b.frames) {
        expected_ns += 1000 * bits_by_the_book(frame);
        EXPECT_EQ(frame.stamp_ns, expected_ns);
        expected_ns += 3000;
    }
    EXPECT_EQ(bus.busy_bits() * 1000, static_cast<std::uint64_t>(expected_ns));
}

TEST(Can_bus, a_frame_on_the_wire_is_not_interrupted) {
    Scheduler scheduler;
    Can_bus bus(scheduler, 500'000);
    Recorder recorder;
    const int node = bus.attach(recorder);
    bus.send(node, make_frame(0x700, {0x55}));
    scheduler.at(10'000, [&] { bus.send(node, make_frame(0x001, {})); });
    while (scheduler.run_one(ns_per_ms)) {
    }
    ASSERT_EQ(recorder.frames.size(), 2U);
    EXPECT_EQ(recorder.frames[0].id, 0x700U);
    EXPECT_EQ(recorder.frames[0].stamp_ns, 2000 * bits_by_the_book(recorder.frames[0]));
}

TEST(Can_bus, a_lost_frame_takes_its_time_and_reaches_nobody_and_a_delayed_one_comes_later) {
    Scheduler scheduler;
    Can_bus bus(scheduler, 1'000'000);
    Recorder recorder;
    const int node = bus.attach(recorder);
    int judged = 0;
    bus.set_judge([&](const gn_can_frame &frame, std::int64_t, std::int64_t &delay_ns) {
        ++judged;
        delay_ns = 700'000;
        return frame.id == 0x100 ? Frame_fate::lose : frame.id == 0x110 ? Frame_fate::delay : Frame_fate::deliver;
    });
    for (const std::uint32_t id : {0x100U, 0x110U, 0x120U}) {
        bus.send(node, make_frame(id, {}));
    }
    while (scheduler.run_one(2 * ns_per_ms)) {
    }
    ASSERT_EQ(recorder.frames.size(), 2U);
    EXPECT_EQ(recorder.frames[0].id, 0x120U);
    const std::int64_t lost_ns = 1000 * (bits_by_the_book(make_frame(0x100, {})) + 3);
    EXPECT_EQ(recorder.frames[0].stamp_ns, lost_ns + 1000 * bits_by_the_book(make_frame(0x120, {})));
    EXPECT_EQ(recorder.frames[1].id, 0x110U);
    EXPECT_EQ(recorder.frames[1].stamp_ns, lost_ns + 700'000 + 1000 * bits_by_the_book(make_frame(0x110, {})));
    EXPECT_EQ(judged, 3);
    EXPECT_EQ(bus.frames(), 3U);
}

TEST(Can_bus, in_front_of_a_real_bus_frames_take_no_time_and_keep_their_order) {
    Scheduler scheduler(1000);
    Can_bus bus(scheduler, Can_bus::no_bit_times);
    Recorder bridge;
    Recorder drive;
    bus.attach(bridge);
    const int node = bus.attach(drive);
    bus.send(node, make_frame(0x181, {1}));
    bus.send(node, make_frame(0x181, {2}));
    while (scheduler.run_one(1000)) {
    }
    ASSERT_EQ(bridge.frames.size(), 2U);
    EXPECT_EQ(bridge.frames[0].stamp_ns, 1000);
    EXPECT_EQ(bridge.frames[1].data[0], 2);
}

TEST(Can_bus, what_a_real_bus_carried_keeps_its_stamp_and_does_not_go_back) {
    Scheduler scheduler(5000);
    Can_bus bus(scheduler, Can_bus::no_bit_times);
    Recorder bridge;
    Recorder drive;
    const int wire = bus.attach(bridge);
    bus.attach(drive);
    gn_can_frame sync = make_frame(0x080, {});
    sync.stamp_ns = 4321;
    bus.hear(wire, sync);
    ASSERT_EQ(drive.frames.size(), 1U);
    EXPECT_EQ(drive.frames[0].stamp_ns, 4321);
    EXPECT_FALSE(drive.frames[0].own_echo);
    EXPECT_TRUE(bridge.frames.empty());
    bus.set_judge([](const gn_can_frame &, std::int64_t, std::int64_t &delay_ns) {
        delay_ns = 100;
        return Frame_fate::delay;
    });
    bus.hear(wire, sync);
    EXPECT_EQ(drive.frames.size(), 1U);
    while (scheduler.run_one(5100)) {
    }
    EXPECT_EQ(drive.frames.size(), 2U);
    bus.set_judge([](const gn_can_frame &, std::int64_t, std::int64_t &) { return Frame_fate::lose; });
    bus.hear(wire, sync);
    EXPECT_EQ(drive.frames.size(), 2U);
}

} // namespace
} // namespace gonio::sim
