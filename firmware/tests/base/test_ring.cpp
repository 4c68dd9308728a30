// test_ring.cpp: the ring between the two threads keeps order, refuses when full and survives the wrap of its counters.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>

extern "C" {
#include "ring.h"
}

namespace {

struct Record {
    uint64_t number;
    uint32_t check;
};

constexpr uint32_t capacity = 8;

class Ring : public testing::Test {
protected:
    void SetUp() override { gn_ring_init(&ring, slots.data(), sizeof(Record), capacity); }

    bool push(uint64_t number) {
        const Record record{number, static_cast<uint32_t>(number * 2654435761U)};
        return gn_ring_push(&ring, &record);
    }

    std::array<Record, capacity> slots{};
    gn_ring ring{};
};

TEST_F(Ring, KeepsOrderAndRefusesWhenFull) {
    Record record{};
    EXPECT_FALSE(gn_ring_pop(&ring, &record));
    for (uint64_t number = 0; number < capacity; number++) {
        EXPECT_TRUE(push(number));
    }
    EXPECT_FALSE(push(capacity));
    EXPECT_EQ(ring.dropped, 1U);
    EXPECT_EQ(gn_ring_fill(&ring), capacity);
    for (uint64_t number = 0; number < capacity; number++) {
        ASSERT_TRUE(gn_ring_pop(&ring, &record));
        EXPECT_EQ(record.number, number);
    }
    EXPECT_FALSE(gn_ring_pop(&ring, &record));
}

TEST_F(Ring, CountersMayWrap) {
    ring.write = ring.read = UINT32_MAX - 2;
    Record record{};
    for (uint64_t number = 0; number < 20; number++) {
        ASSERT_TRUE(push(number));
        ASSERT_TRUE(gn_ring_pop(&ring, &record));
        EXPECT_EQ(record.number, number);
    }
    EXPECT_EQ(ring.dropped, 0U);
}

// One thread writes, one reads: every record arrives once, whole and in order.
TEST_F(Ring, CarriesRecordsBetweenTwoThreads) {
    constexpr uint64_t records = 200000;
    std::thread producer([this] {
        for (uint64_t number = 0; number < records;) {
            if (push(number)) {
                number++;
            } else {
                std::this_thread::yield();
            }
        }
    });
    uint64_t wrong = 0;
    Record record{};
    for (uint64_t number = 0; number < records;) {
        if (!gn_ring_pop(&ring, &record)) {
            std::this_thread::yield();
            continue;
        }
        wrong += record.number != number || record.check != static_cast<uint32_t>(number * 2654435761U) ? 1 : 0;
        number++;
    }
    producer.join();
    EXPECT_EQ(wrong, 0U);
}

} // namespace
