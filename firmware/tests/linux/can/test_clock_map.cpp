// test_clock_map.cpp: stamps of a wall clock that steps, against the controller time at which they were made.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

extern "C" {
#include "clock_map.h"
}

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t begin_ns = 5'000'000'000;
constexpr std::int64_t epoch_ns = 1'700'000'000'000'000'000;

// Both clocks, and a socket's view of them.
struct Clocks {
    std::int64_t now_ns = begin_ns;
    std::int64_t offset_ns = epoch_ns;
    gn_clock_map map{};

    Clocks() {
        auto const pair = read();
        gn_clock_map_init(&map, &pair);
    }
    gn_clock_pair read(std::int64_t width_ns = 100) {
        gn_clock_pair pair{};
        pair.before_ns = now_ns;
        pair.real_ns = now_ns + width_ns / 2 + offset_ns;
        pair.after_ns = now_ns += width_ns;
        return pair;
    }
    std::int64_t real() const { return now_ns + offset_ns; }
    // A look at the socket that finds a frame with this stamp.
    std::int64_t take(std::int64_t real_ns, bool &by_arrival, std::int64_t width_ns = 100) {
        auto const pair = read(width_ns);
        gn_clock_map_update(&map, &pair);
        return gn_clock_map_stamp(&map, real_ns, now_ns, &by_arrival);
    }
    void find_empty() {
        auto const pair = read();
        gn_clock_map_update(&map, &pair);
        gn_clock_map_drained(&map, pair.before_ns);
    }
};

TEST(Clock_map, stamps_become_controller_time) {
    Clocks clocks;
    std::mt19937 random(1);
    for (int i = 0; i < 1000; i++) {
        clocks.find_empty();
        clocks.now_ns += static_cast<std::int64_t>(random() % 2'000'000);
        std::int64_t const made_ns = clocks.now_ns;
        std::int64_t const real_ns = clocks.real();
        clocks.now_ns += static_cast<std::int64_t>(random() % 50'000);
        bool by_arrival = true;
        std::int64_t const stamp_ns = clocks.take(real_ns, by_arrival, 100 + static_cast<std::int64_t>(random() % 500));
        EXPECT_FALSE(by_arrival);
        EXPECT_NEAR(static_cast<double>(stamp_ns - made_ns), 0.0, 51.0); // half of the narrowest reading
    }
    EXPECT_EQ(clocks.map.steps, 0u);
}

// NTP slews both clocks alike, but a reading may be interrupted for long: that is no step.
TEST(Clock_map, an_interrupted_reading_is_no_step) {
    Clocks clocks;
    bool by_arrival = true;
    std::int64_t const made_ns = clocks.now_ns += ms;
    EXPECT_NEAR(static_cast<double>(clocks.take(clocks.real(), by_arrival, 3 * ms) - made_ns), 0.0, 51.0);
    EXPECT_FALSE(by_arrival);
    EXPECT_EQ(clocks.map.steps, 0u);
}

TEST(Clock_map, a_frame_of_before_the_step_keeps_its_time) {
    for (std::int64_t const step_ns : {3'600'000 * ms, -3'600'000 * ms, 100 * ms, -100 * ms}) {
        Clocks clocks;
        bool by_arrival = true;
        clocks.find_empty();
        std::int64_t const first_ns = clocks.now_ns += ms;
        std::int64_t const first_real_ns = clocks.real();
        clocks.now_ns += ms;
        clocks.offset_ns += step_ns;
        std::int64_t const second_ns = clocks.now_ns += ms;
        std::int64_t const second_real_ns = clocks.real();
        clocks.now_ns += ms;
        EXPECT_NEAR(static_cast<double>(clocks.take(first_real_ns, by_arrival) - first_ns), 0.0, 51.0);
        EXPECT_FALSE(by_arrival) << step_ns;
        EXPECT_NEAR(static_cast<double>(clocks.take(second_real_ns, by_arrival) - second_ns), 0.0, 51.0);
        EXPECT_FALSE(by_arrival) << step_ns;
        EXPECT_EQ(clocks.map.steps, 1u);
    }
}

// Made before the step, seen after the socket had been found empty: its offset is no longer known.
TEST(Clock_map, a_stamp_that_fits_nowhere_is_the_time_of_reading) {
    Clocks clocks;
    bool by_arrival = false;
    std::int64_t const real_ns = clocks.real();
    clocks.offset_ns += 1000 * ms;
    clocks.now_ns += ms;
    clocks.find_empty();
    EXPECT_EQ(clocks.take(real_ns, by_arrival), clocks.now_ns);
    EXPECT_TRUE(by_arrival);
    EXPECT_EQ(clocks.take(clocks.real() + ms, by_arrival), clocks.now_ns); // from the future
    EXPECT_TRUE(by_arrival);
}

// Both offsets would do: a guess would be wrong by the step, unseen.
TEST(Clock_map, a_small_step_between_looks_is_not_guessed_at) {
    Clocks clocks;
    bool by_arrival = false;
    clocks.find_empty();
    clocks.now_ns += ms;
    std::int64_t const real_ns = clocks.real();
    clocks.offset_ns -= ms / 2;
    clocks.now_ns += ms;
    EXPECT_EQ(clocks.take(real_ns, by_arrival), clocks.now_ns);
    EXPECT_TRUE(by_arrival);
    EXPECT_EQ(clocks.map.steps, 1u);
    clocks.find_empty(); // from here on all is clear again
    std::int64_t const made_ns = clocks.now_ns += ms;
    EXPECT_NEAR(static_cast<double>(clocks.take(clocks.real(), by_arrival) - made_ns), 0.0, 51.0);
    EXPECT_FALSE(by_arrival);
}

TEST(Clock_map, every_step_counts_once_and_slight_ones_do_not) {
    Clocks clocks;
    clocks.offset_ns += 500; // below the threshold, beyond the reading's width
    for (int i = 0; i < 10; i++) {
        clocks.find_empty();
    }
    EXPECT_EQ(clocks.map.steps, 0u);
    clocks.offset_ns -= 37'000 * ms;
    for (int i = 0; i < 10; i++) {
        clocks.find_empty();
    }
    EXPECT_EQ(clocks.map.steps, 1u);
}

} // namespace
