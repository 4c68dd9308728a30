// test_frame_ring.cpp: the transmit and replay ring, against a plain deque of frames.
#include <cstdint>
#include <cstring>
#include <deque>
#include <random>
#include <vector>

#include <gtest/gtest.h>

extern "C" {
#include "frame.h"
#include "frame_ring.h"
}

namespace {

struct Ring {
    std::vector<std::uint8_t> bytes;
    gn_frame_ring ring{};

    explicit Ring(std::uint32_t capacity) : bytes(capacity) { gn_frame_ring_init(&ring, bytes.data(), capacity); }

    void put(std::uint8_t fill, std::uint32_t length, std::uint32_t reserved_more = 0) {
        std::memset(gn_frame_ring_reserve(&ring, length + reserved_more), fill, length);
        gn_frame_ring_commit(&ring, GN_FRAME_EVENT, length);
    }

    // Sequence of the next frame, or 0 for none; checks its payload.
    std::uint32_t send(std::uint8_t fill, std::uint32_t length) {
        std::uint32_t size = 0;
        const std::uint8_t *frame = gn_frame_ring_next(&ring, &size);
        if (frame == nullptr) {
            return 0;
        }
        gn_frame_header const header = gn_frame_header_at(frame);
        EXPECT_EQ(std::uint32_t{header.length}, length);
        EXPECT_EQ(size, GN_FRAME_HEADER_SIZE + length);
        for (std::uint32_t i = 0; i < length; ++i) {
            EXPECT_EQ(frame[GN_FRAME_HEADER_SIZE + i], fill);
        }
        gn_frame_ring_advance(&ring);
        return header.sequence;
    }
};

TEST(Frame_ring, numbers_from_one_and_replays_what_follows_the_last_received) {
    Ring ring(4096);
    for (std::uint8_t i = 1; i <= 5; ++i) {
        ring.put(i, 10u + i, 7);
    }
    for (std::uint8_t i = 1; i <= 4; ++i) {
        EXPECT_EQ(ring.send(i, 10u + i), i);
    }
    EXPECT_TRUE(gn_frame_ring_acknowledge(&ring.ring, 1));
    EXPECT_FALSE(gn_frame_ring_acknowledge(&ring.ring, 5)) << "frame 5 was not sent";
    EXPECT_TRUE(gn_frame_ring_replay(&ring.ring, 2));
    for (std::uint8_t i = 3; i <= 5; ++i) {
        EXPECT_EQ(ring.send(i, 10u + i), i);
    }
    EXPECT_EQ(ring.send(0, 0), 0u);
    EXPECT_FALSE(gn_frame_ring_replay(&ring.ring, 6)) << "there never was a frame 6";
    EXPECT_EQ(ring.ring.gap_frames, 0u);
}

TEST(Frame_ring, overflow_drops_the_oldest_and_counts_what_the_host_never_gets) {
    Ring ring(10 * 100);
    for (std::uint8_t i = 1; i <= 10; ++i) {
        ring.put(i, 80);
    }
    EXPECT_EQ(ring.send(1, 80), 1u);
    EXPECT_EQ(ring.send(2, 80), 2u);
    for (std::uint8_t i = 11; i <= 15; ++i) { // 1 and 2 were sent; 3, 4, 5 fall out unsent
        ring.put(i, 80);
    }
    EXPECT_EQ(ring.ring.gap_frames, 3u);
    EXPECT_EQ(ring.send(6, 80), 6u);
    EXPECT_TRUE(gn_frame_ring_replay(&ring.ring, 1)); // so frame 2 did not arrive, and is gone
    EXPECT_EQ(ring.ring.gap_frames, 4u);
    EXPECT_EQ(ring.send(6, 80), 6u);
}

TEST(Frame_ring, holds_ten_seconds_at_full_rate) {
    Ring ring(1u << 20);
    for (int tenth = 0; tenth < 100; ++tenth) { // 1 kHz samples, 500 Hz poses, Status; Counters each second
        ring.put(1, GN_SAMPLE_BLOCK_SIZE + 100 * GN_SAMPLE_SIZE);
        ring.put(2, GN_POSE_BLOCK_SIZE + 50 * GN_POSE_SIZE);
        ring.put(3, 90);
        if (tenth % 10 == 0) {
            ring.put(4, 180);
        }
    }
    EXPECT_EQ(ring.ring.oldest_sequence, 1u);
    EXPECT_EQ(ring.ring.gap_frames, 0u);
}

TEST(Frame_ring, agrees_with_a_deque_under_random_use) {
    struct Kept {
        std::uint32_t sequence;
        std::uint8_t fill;
        std::uint32_t length;
    };
    Ring ring(3000);
    std::mt19937 random(7);
    std::deque<Kept> kept; // what the ring may still hold, oldest first
    std::uint32_t sent = 0;
    std::uint32_t acknowledged = 0;
    std::uint32_t made = 0;
    for (int step = 0; step < 20000; ++step) {
        switch (random() % 4) {
        case 0:
        case 1: {
            auto const fill = static_cast<std::uint8_t>(random());
            std::uint32_t const length = static_cast<std::uint32_t>(random() % 700);
            ring.put(fill, length, static_cast<std::uint32_t>(random() % 50));
            kept.push_back({++made, fill, length});
            break;
        }
        case 2: {
            while (!kept.empty() && kept.front().sequence < ring.ring.oldest_sequence) {
                kept.pop_front();
            }
            auto next = kept.begin();
            while (next != kept.end() && next->sequence <= sent) {
                ++next;
            }
            if (next == kept.end()) {
                EXPECT_EQ(ring.send(0, 0), 0u);
            } else {
                sent = next->sequence;
                EXPECT_EQ(ring.send(next->fill, next->length), sent);
            }
            break;
        }
        default:
            if (sent > acknowledged) {
                acknowledged += static_cast<std::uint32_t>(random() % (sent - acknowledged + 1));
                EXPECT_TRUE(gn_frame_ring_acknowledge(&ring.ring, acknowledged));
                if (random() % 8 == 0) {
                    EXPECT_TRUE(gn_frame_ring_replay(&ring.ring, acknowledged));
                    sent = acknowledged;
                }
            }
        }
        std::uint32_t held = 0; // no frame falls out while half of the bytes would hold all
        for (auto const &frame : kept) {
            held += frame.sequence > acknowledged ? GN_FRAME_HEADER_SIZE + frame.length : 0;
        }
        if (held < 1400 && !kept.empty()) {
            ASSERT_LE(ring.ring.next_sequence - ring.ring.oldest_sequence, kept.size());
        }
    }
    EXPECT_GT(ring.ring.gap_frames, 100u);
    EXPECT_EQ(ring.ring.next_sequence, made + 1u);
}

} // namespace
