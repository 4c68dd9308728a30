// test_homing.cpp: homing by CiA 402: method 1 exact to the index pulse from anywhere, 35 and 37, errors, interruption.
#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"

namespace gonio::sim {
namespace {

constexpr double counts_per_deg = 10000.0 / 9.0;
constexpr std::uint16_t attained = 0x1000, error = 0x2000, reached = 0x400;

Drive_config at_deg(double start_deg, const std::string &personality = "full") {
    Drive_config config = Bench::standard(1, personality);
    config.initial_position_counts = start_deg * counts_per_deg;
    config.negative_switch_counts = -6.0 * counts_per_deg;
    return config;
}

// Everything by SDO, so that it is the same for every PDO map.
void begin(Bench &bench, int method, std::int32_t home_offset) {
    EXPECT_EQ(bench.write(0x607C, 0, home_offset, 4), 0U);
    EXPECT_EQ(bench.write(0x6098, 0, method, 1), 0U);
    EXPECT_EQ(bench.write(0x6099, 1, 11111, 4), 0U);
    EXPECT_EQ(bench.write(0x6099, 2, 1111, 4), 0U);
    EXPECT_EQ(bench.write(0x6060, 0, 6, 1), 0U);
    for (const int controlword : {0x06, 0x07, 0x0F, 0x1F}) {
        EXPECT_EQ(bench.write(0x6040, 0, controlword, 2), 0U);
    }
}
void wait(Bench &bench) {
    for (int k = 0; k < 40 && (bench.statusword() & (attained | error)) == 0; ++k) {
        bench.run_ms(500);
    }
}

TEST(Homing, method_1_finds_the_index_to_the_count_from_anywhere) {
    const std::int64_t index = std::llround(-6.0 * counts_per_deg);
    for (const double start_deg : {57.123456, 0.0, -5.9, -6.4, -6.64, 3.77}) {
        Bench bench(at_deg(start_deg));
        EXPECT_EQ(bench.read(0x6064), 0); // power-up
        EXPECT_FALSE(bench.drive().homed());
        begin(bench, 1, static_cast<std::int32_t>(index));
        wait(bench);
        EXPECT_EQ(bench.statusword() & (attained | error | reached), attained | reached) << start_deg;
        EXPECT_TRUE(bench.drive().homed());
        const double there = bench.drive().true_position_counts(bench.scheduler.now_ns());
        EXPECT_EQ(bench.read(0x6064), std::llround(there)) << start_deg;
        EXPECT_GT(there, static_cast<double>(index)); // it stops beyond the pulse, by v^2 / 2a and the lag
        EXPECT_LT(there, static_cast<double>(index) + 60.0);
    }
}

TEST(Homing, goes_to_the_switch_fast_and_leaves_it_slowly) {
    Bench bench(at_deg(20.0));
    begin(bench, 1, 0);
    double fastest_down = 0.0;
    double fastest_up = 0.0;
    double lowest = 1.0e9;
    for (int k = 0; k < 6000; ++k) {
        bench.run_ms(1);
        fastest_down = std::min(fastest_down, bench.drive().true_velocity_counts_per_s());
        fastest_up = std::max(fastest_up, bench.drive().true_velocity_counts_per_s());
        lowest = std::min(lowest, bench.drive().true_position_counts(bench.scheduler.now_ns()));
    }
    EXPECT_NEAR(fastest_down, -11111.0, 20.0);
    EXPECT_NEAR(fastest_up, 1111.0, 20.0);
    // Switch 700 counts before the index, then the way to stop from full speed at 0x609A.
    EXPECT_NEAR(lowest, -6667.0 - 700.0 - 11111.0 * 11111.0 / (2.0 * 66667.0), 120.0);
    EXPECT_TRUE(bench.drive().homed());
    EXPECT_EQ(bench.read(0x60FD) & 1, 0);
}

TEST(Homing, a_second_homing_gives_the_same_coordinate) {
    Bench bench(at_deg(2.5));
    begin(bench, 1, -6667);
    wait(bench);
    const double offset =
        static_cast<double>(bench.read(0x6064)) - bench.drive().true_position_counts(bench.scheduler.now_ns());
    bench.write(0x6040, 0, 0x0F, 2);
    bench.write(0x6040, 0, 0x1F, 2);
    EXPECT_EQ(bench.statusword() & attained, 0);
    EXPECT_FALSE(bench.drive().homed());
    wait(bench);
    EXPECT_TRUE(bench.drive().homed());
    EXPECT_NEAR(static_cast<double>(bench.read(0x6064)) - bench.drive().true_position_counts(bench.scheduler.now_ns()),
                offset, 1.0);
    EXPECT_NEAR(offset, 0.0, 0.5 + 1.0e-9);
}

TEST(Homing, methods_35_and_37_take_the_present_position) {
    for (const int method : {35, 37}) {
        Bench bench(at_deg(12.0));
        begin(bench, method, 4321);
        wait(bench);
        EXPECT_EQ(bench.read(0x6064), 4321);
        EXPECT_TRUE(bench.drive().homed());
        EXPECT_NEAR(bench.drive().true_position_counts(bench.scheduler.now_ns()), 12.0 * counts_per_deg, 1.0);
    }
}

TEST(Homing, without_a_method_is_an_error) {
    Bench bench(at_deg(12.0));
    begin(bench, 0, 0);
    bench.run_ms(10);
    EXPECT_EQ(bench.statusword() & (attained | error), error);
    EXPECT_FALSE(bench.drive().homed());
}

TEST(Homing, is_interrupted_by_taking_back_the_start_bit) {
    Bench bench(at_deg(50.0));
    begin(bench, 1, 0);
    bench.run_ms(500);
    EXPECT_LT(bench.drive().true_velocity_counts_per_s(), -5000.0);
    bench.write(0x6040, 0, 0x0F, 2);
    bench.run_ms(500);
    EXPECT_NEAR(bench.drive().true_velocity_counts_per_s(), 0.0, 1.0);
    EXPECT_EQ(bench.statusword() & (attained | error | reached), reached);
    EXPECT_FALSE(bench.drive().homed());
}

TEST(Homing, fails_when_the_axis_is_blocked) {
    Bench bench(at_deg(50.0));
    begin(bench, 1, 0);
    bench.run_ms(200);
    bench.drive().block(true);
    bench.run_ms(1500);
    EXPECT_EQ(bench.emergencies(), (std::vector<std::uint16_t>{0x8611}));
    EXPECT_EQ(state_bits(bench.statusword()) & 0x4FU, 0x08);
    EXPECT_EQ(bench.statusword() & (attained | error), error);
}

TEST(Homing, is_lost_with_a_reset) {
    Bench bench(at_deg(5.0));
    begin(bench, 37, 100);
    wait(bench);
    bench.nmt(0x81);
    bench.run_ms(100);
    EXPECT_FALSE(bench.drive().homed());
    EXPECT_EQ(bench.read(0x6064), 0);
}

TEST(Homing, works_in_every_personality) {
    for (const char *personality : {"basic", "fixed"}) {
        Bench bench(at_deg(4.0, personality));
        begin(bench, 1, -6667);
        wait(bench);
        EXPECT_EQ(bench.read(0x6064), std::llround(bench.drive().true_position_counts(bench.scheduler.now_ns())))
            << personality;
    }
}

} // namespace
} // namespace gonio::sim
