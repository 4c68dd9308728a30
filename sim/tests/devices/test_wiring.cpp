// test_wiring.cpp: what is wrong outside the drive: a motor that turns the other way, an axis driven onto its switch, a
// drive that loses its supply, a master that dies.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"

namespace gonio::sim {
namespace {

constexpr std::uint16_t internal_limit = 0x800;
constexpr std::uint16_t fault_bit = 0x08;

// A ramp of 40 counts per cycle of 2 ms (20,000 counts/s) in mode 8, until the drive faults.
int ride(Bench &bench, std::int32_t start_counts, int cycles, std::int32_t step_counts) {
    for (int k = 1; k <= cycles; ++k) {
        bench.cycle(0x0F, start_counts + k * step_counts);
        if ((bench.drive().statusword() & fault_bit) != 0) {
            return k;
        }
    }
    return cycles;
}

void watch_following(Bench &bench, std::int64_t window_counts) {
    bench.write(0x6065, 0, window_counts, 4);
    bench.write(0x6066, 0, 10, 2);
}

TEST(Wiring, a_motor_that_turns_the_other_way_is_a_following_error_at_the_first_motion) {
    Drive_config config = Bench::standard();
    config.inverted = true;
    Bench bench(config);
    watch_following(bench, 2000);
    bench.enable();
    for (int k = 0; k < 50; ++k) {
        bench.cycle(0x0F, 0);
    }
    EXPECT_NEAR(bench.drive().true_position_counts(bench.scheduler.now_ns()), 0.0, 1.0) << "standing it does not show";
    const int cycles = ride(bench, 0, 400, 40);
    // It moves away at the same speed: 2 x 40 counts per cycle reach 2000 after 25 cycles and the lag.
    EXPECT_GE(cycles, 22);
    EXPECT_LE(cycles, 45);
    EXPECT_LT(bench.drive().true_position_counts(bench.scheduler.now_ns()), -800.0);
    EXPECT_EQ(bench.emergencies().back(), 0x8611);
}

TEST(Wiring, an_axis_driven_onto_its_negative_switch_stops_there_and_says_so) {
    Drive_config config = Bench::standard();
    config.negative_switch_counts = -3000.0;
    config.switch_to_index_counts = 0.0;
    Bench bench(config);
    watch_following(bench, 4000);
    bench.enable();
    ride(bench, 0, 60, -40);
    EXPECT_EQ(bench.drive().statusword() & internal_limit, 0) << "not there yet";
    ride(bench, -2400, 30, -40);
    EXPECT_NE(bench.drive().statusword() & internal_limit, 0);
    bench.run_ms(20);
    // It may overshoot by what its acceleration allows: v^2 / 2a = 200 counts.
    const double there = bench.drive().true_position_counts(bench.scheduler.now_ns());
    EXPECT_NEAR(there, -3000.0, 210.0);
    EXPECT_LE(there, -2995.0);
    const int cycles = ride(bench, -3600, 200, -40);
    EXPECT_LT(cycles, 200) << "the set-point runs away from an axis that stands";
    EXPECT_EQ(bench.emergencies().back(), 0x8611);
    EXPECT_GT(bench.drive().true_position_counts(bench.scheduler.now_ns()), -3300.0);
}

TEST(Wiring, from_the_switch_an_axis_may_move_away) {
    Drive_config config = Bench::standard();
    config.negative_switch_counts = 500.0; // it stands on it at power-up
    config.switch_to_index_counts = 0.0;
    Bench bench(config);
    bench.enable();
    ride(bench, 0, 25, -40);
    EXPECT_NEAR(bench.drive().true_position_counts(bench.scheduler.now_ns()), 0.0, 1.0);
    EXPECT_NE(bench.drive().statusword() & internal_limit, 0);
    ride(bench, 0, 50, 40);
    bench.cycle(0x0F, 2000); // a target is taken over at the next SYNC
    bench.run_ms(50);
    EXPECT_NEAR(bench.drive().true_position_counts(bench.scheduler.now_ns()), 2000.0, 2.0);
    EXPECT_EQ(bench.drive().statusword() & internal_limit, 0);
}

TEST(Wiring, a_drive_without_supply_is_dead_and_boots_when_it_has_it_again) {
    Bench bench(Bench::standard());
    bench.enable();
    bench.drive().power(false);
    bench.run_ms(200);
    EXPECT_TRUE(bench.exchange({0x40, 0x00, 0x10, 0, 0, 0, 0, 0}).empty());
    EXPECT_FALSE(bench.drive().energised());
    const std::size_t boots = bench.frames_with(0x701).size();
    bench.drive().power(true);
    bench.run_ms(100);
    EXPECT_EQ(bench.frames_with(0x701).size(), boots + 1);
    EXPECT_EQ(bench.drive().nmt_state(), 127);
    EXPECT_EQ(bench.read(0x1017), 0) << "settings that were not stored are gone";
}

// Without set-points the axis stops dead at the last one that a SYNC brought. With an RPDO deadline (0x1400:05) the
// drive says so and takes the axis out of operation; with neither deadline nor heartbeat consumer nobody says a word.
TEST(Wiring, when_the_master_dies_the_axis_stops_dead_and_a_deadline_takes_it_out_of_operation) {
    for (const bool deadline : {true, false}) {
        Bench bench(Bench::standard());
        watch_following(bench, 0xFFFFFFFF);
        bench.enable();
        if (deadline) {
            ASSERT_EQ(bench.write(0x1400, 5, 30, 2), 0U);
        }
        ride(bench, 0, 100, 40);
        const std::size_t said = bench.emergencies().size();
        bench.run_ms(500);
        EXPECT_NEAR(bench.drive().true_velocity_counts_per_s(), 0.0, 1.0);
        EXPECT_EQ(bench.emergencies().size() > said, deadline);
        EXPECT_EQ((bench.drive().statusword() & 0x6FU) == 0x27U, !deadline) << "operation enabled";
        EXPECT_NEAR(bench.drive().true_position_counts(bench.scheduler.now_ns()), 3960.0, 1.0);
    }
}

} // namespace
} // namespace gonio::sim
