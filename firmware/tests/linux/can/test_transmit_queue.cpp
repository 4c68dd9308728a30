// test_transmit_queue.cpp: what leaves, in which order, and what a newer setpoint replaces.
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

extern "C" {
#include "transmit_queue.h"
}

namespace {

gn_can_frame frame(std::uint32_t id, std::uint8_t first = 0) {
    gn_can_frame f{};
    f.id = id;
    f.length = 1;
    f.data[0] = first;
    return f;
}

std::string drain(gn_transmit_queue &queue) {
    std::string text;
    while (const gn_can_frame *front = gn_transmit_queue_front(&queue)) {
        char word[32];
        (void)std::snprintf(word, sizeof word, "%03X.%d ", front->id, front->data[0]);
        text += word;
        gn_transmit_queue_pop(&queue);
    }
    return text;
}

TEST(Transmit_queue, keeps_the_order) {
    gn_transmit_queue queue{};
    for (std::uint32_t const id : {0x080u, 0x201u, 0x202u, 0x601u, 0x701u, 0x000u}) {
        auto const f = frame(id);
        EXPECT_TRUE(gn_transmit_queue_push(&queue, &f));
    }
    EXPECT_EQ(drain(queue), "080.0 201.0 202.0 601.0 701.0 000.0 ");
    EXPECT_EQ(queue.setpoints_dropped, 0u);
}

// The newer setpoint was computed after the second SYNC: before it, it would take effect a cycle too early.
TEST(Transmit_queue, a_newer_setpoint_replaces_the_older_and_goes_to_the_end) {
    gn_transmit_queue queue{};
    for (auto const &f : {frame(0x080, 1), frame(0x201, 1), frame(0x202, 1), frame(0x080, 2), frame(0x201, 2)}) {
        EXPECT_TRUE(gn_transmit_queue_push(&queue, &f));
    }
    EXPECT_EQ(drain(queue), "080.1 202.1 080.2 201.2 ");
    EXPECT_EQ(queue.setpoints_dropped, 1u);
}

TEST(Transmit_queue, nothing_but_setpoints_is_replaced) {
    gn_transmit_queue queue{};
    for (std::uint32_t const id : {0x000u, 0x080u, 0x180u, 0x200u, 0x281u, 0x601u, 0x77Fu}) {
        for (std::uint8_t i = 1; i <= 2; i++) {
            auto const f = frame(id, i);
            EXPECT_TRUE(gn_transmit_queue_push(&queue, &f));
        }
    }
    EXPECT_EQ(queue.count, 14u);
    EXPECT_EQ(queue.setpoints_dropped, 0u);
}

TEST(Transmit_queue, refuses_only_when_full) {
    gn_transmit_queue queue{};
    auto const setpoint = frame(0x27F, 1);
    auto const sync = frame(0x080);
    EXPECT_TRUE(gn_transmit_queue_push(&queue, &setpoint));
    for (std::uint32_t i = 1; i < GN_TRANSMIT_CAPACITY; i++) {
        EXPECT_TRUE(gn_transmit_queue_push(&queue, &sync));
    }
    EXPECT_FALSE(gn_transmit_queue_push(&queue, &sync));
    auto const other = frame(0x201);
    EXPECT_FALSE(gn_transmit_queue_push(&queue, &other));
    auto const newer = frame(0x27F, 2);
    EXPECT_TRUE(gn_transmit_queue_push(&queue, &newer)); // takes the place of its elder
    EXPECT_EQ(queue.count, GN_TRANSMIT_CAPACITY);
    EXPECT_EQ(queue.frames[GN_TRANSMIT_CAPACITY - 1].data[0], 2);
    gn_transmit_queue_clear(&queue);
    EXPECT_EQ(gn_transmit_queue_front(&queue), nullptr);
    gn_transmit_queue_pop(&queue);
    EXPECT_EQ(queue.count, 0u);
}

} // namespace
