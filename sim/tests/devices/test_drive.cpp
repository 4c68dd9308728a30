// test_drive.cpp: a drive in its cycle: set-points, latched positions, limits, following error, STO, brake, stops.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench.hpp"

namespace gonio::sim {
namespace {

constexpr double omega_rad_per_s = 2.0 * std::numbers::pi * 50.0;
constexpr double speed_counts_per_s = 30.0 * 10000.0 / 9.0;

std::int32_t position_of(const gn_can_frame &frame) {
    return static_cast<std::int32_t>(value_from_bytes(&frame.data[2], 4, true));
}

// Runs at constant velocity; the last target.
std::int32_t run_up(Bench &bench, int cycles, double start = 0.0) {
    double target = start;
    for (int k = 0; k < cycles; ++k) {
        target += speed_counts_per_s * 0.002;
        bench.cycle(0x0F, static_cast<std::int32_t>(std::lround(target)));
    }
    return static_cast<std::int32_t>(std::lround(target));
}

TEST(Drive, latches_the_position_at_the_sync_plus_its_latch_delay) {
    for (const double delay_us : {0.0, 130.0, 900.0}) {
        Drive_config config = Bench::standard();
        config.latch_delay_us = delay_us;
        config.initial_position_counts = 1000.4;
        Bench bench(config);
        bench.enable();
        std::uint32_t random = 1;
        double fastest = 0.0;
        for (int k = 0; k < 300; ++k) {
            const auto target = static_cast<std::int32_t>(std::lround(3000.0 * std::sin(0.022 * k)));
            const std::size_t before = bench.recorder.frames.size();
            const std::int64_t start_ns = bench.scheduler.now_ns();
            bench.send(0x80, {});
            bench.set_point(0x0F, target);
            bench.run_ms(1.9);
            std::int64_t sync_ns = 0;
            const gn_can_frame *answer = nullptr;
            for (std::size_t m = before; m < bench.recorder.frames.size(); ++m) {
                const gn_can_frame &frame = bench.recorder.frames[m];
                sync_ns = frame.id == 0x80 ? frame.stamp_ns : sync_ns;
                answer = frame.id == 0x181 ? &frame : answer;
            }
            ASSERT_NE(answer, nullptr);
            const auto latch_ns = sync_ns + static_cast<std::int64_t>(delay_us * 1000.0);
            EXPECT_EQ(position_of(*answer) + 1000, std::llround(bench.drive().true_position_counts(latch_ns)));
            fastest = std::max(fastest, std::abs(bench.drive().true_velocity_counts_per_s()));
            random = random * 1664525U + 1013904223U; // SYNC jitter of up to 120 us
            bench.run_until(start_ns + 2 * ns_per_ms + static_cast<std::int64_t>(random % 120000U));
        }
        EXPECT_GT(fastest, 0.9 * 3000.0 * 0.022 / 0.00206);
    }
}

TEST(Drive, follows_constant_velocity_with_the_followers_lag) {
    Bench bench(Bench::standard());
    bench.enable();
    run_up(bench, 200);
    EXPECT_NEAR(bench.drive().true_velocity_counts_per_s(), speed_counts_per_s, 0.02 * speed_counts_per_s);
    EXPECT_EQ(bench.drive().statusword() & 0x3000U, 0x1000U); // follows its command, no following error
    EXPECT_NEAR(static_cast<double>(bench.read(0x60F4)), 2.0 * speed_counts_per_s / omega_rad_per_s, 3.0);
    bench.run_ms(200);
    EXPECT_EQ(bench.read(0x60F4), 0);
}

TEST(Drive, the_position_offset_is_added_to_the_target) {
    Bench bench(Bench::standard());
    bench.enable();
    bench.write(0x60B0, 0, 150, 4);
    for (int k = 0; k < 50; ++k) {
        bench.cycle(0x0F, 100);
    }
    EXPECT_EQ(bench.read(0x6064), 250);
}

TEST(Drive, a_missed_sync_leaves_no_pdo_and_no_new_set_point) {
    Bench bench(Bench::standard());
    bench.enable();
    const std::size_t before = bench.frames_with(0x181).size();
    bench.drive().skip_next_sync();
    bench.cycle(0x0F, 10);
    EXPECT_EQ(bench.frames_with(0x181).size(), before);
    bench.cycle(0x0F, 20);
    EXPECT_EQ(bench.frames_with(0x181).size(), before + 1);
}

TEST(Drive, a_blocked_axis_trips_the_following_error_after_its_time_out) {
    Bench bench(Bench::standard());
    bench.write(0x6065, 0, 555, 4);
    bench.write(0x6066, 0, 20, 2);
    bench.enable();
    std::int32_t target = run_up(bench, 100);
    EXPECT_TRUE(bench.emergencies().empty());
    bench.drive().block(true);
    const std::int64_t blocked_ns = bench.scheduler.now_ns();
    run_up(bench, 50, target);
    const auto messages = bench.frames_with(0x81);
    ASSERT_EQ(messages.size(), 1U);
    EXPECT_EQ(bench.emergencies()[0], 0x8611);
    EXPECT_EQ(messages[0].data[2], 0x21); // error register: generic, profile
    // The lag of 212 counts grows by the velocity to 555, then the time-out runs; steps of 1 ms.
    const double expected_ms = 1000.0 * (555.0 - 212.2) / speed_counts_per_s + 20.0;
    EXPECT_NEAR(static_cast<double>(messages[0].stamp_ns - blocked_ns) / 1.0e6, expected_ms, 4.0);
    EXPECT_EQ(state_bits(bench.statusword()) & 0x4FU, 0x08);
    EXPECT_EQ(bench.read(0x603F) & 0xFFFF, 0x8611);
    EXPECT_FALSE(bench.drive().energised());

    bench.drive().block(false);
    bench.write(0x6040, 0, 0x80, 2);
    EXPECT_EQ(state_bits(bench.statusword()), 0x40);
    EXPECT_EQ(bench.emergencies().back(), 0x0000);
    EXPECT_EQ(bench.read(0x603F), 0);
}

TEST(Drive, a_window_of_all_ones_watches_nothing) {
    Bench bench(Bench::standard());
    bench.write(0x6065, 0, 0xFFFFFFFF, 4);
    bench.enable();
    bench.drive().block(true);
    run_up(bench, 300);
    EXPECT_TRUE(bench.emergencies().empty());
    EXPECT_EQ(state_bits(bench.statusword()), 0x27);
}

TEST(Drive, sto_takes_the_torque_and_blocks_the_way_back) {
    Bench bench(Bench::standard());
    bench.enable();
    run_up(bench, 100);
    const double speed = bench.drive().true_velocity_counts_per_s();
    bench.drive().set_sto(false);
    const double start = bench.drive().true_position_counts(bench.scheduler.now_ns());
    bench.run_ms(300);
    EXPECT_EQ(bench.emergencies(), (std::vector<std::uint16_t>{0x5090}));
    EXPECT_FALSE(bench.drive().energised());
    EXPECT_EQ(state_bits(bench.statusword()) & 0x4FU, 0x08);
    EXPECT_EQ(bench.drive().true_velocity_counts_per_s(), 0.0);
    // It coasts: friction of 3e5 counts/s^2, and at most one step of the loop before.
    EXPECT_NEAR(bench.drive().true_position_counts(bench.scheduler.now_ns()) - start, speed * speed / 6.0e5,
                speed * 1.1e-3);
    EXPECT_EQ(bench.read(0x60FD) & 8, 8);

    bench.write(0x6040, 0, 0x80, 2);
    EXPECT_EQ(state_bits(bench.statusword()) & 0x4FU, 0x08);
    bench.drive().set_sto(true);
    bench.write(0x6040, 0, 0x00, 2);
    bench.write(0x6040, 0, 0x80, 2);
    EXPECT_EQ(state_bits(bench.statusword()), 0x40);
    bench.drive().set_sto(false);
    bench.write(0x6040, 0, 0x06, 2);
    EXPECT_EQ(state_bits(bench.statusword()), 0x40); // transition 2 is refused
    bench.drive().set_sto(true);
    bench.write(0x6040, 0, 0x06, 2);
    EXPECT_EQ(state_bits(bench.statusword()), 0x21);
    bench.drive().set_sto(false); // not under control: no fault, no emergency
    EXPECT_EQ(state_bits(bench.statusword()), 0x40);
}

TEST(Drive, software_limits_clamp_targets_once_homed) {
    Bench bench(Bench::standard());
    bench.write(0x607D, 1, -500, 4);
    bench.write(0x607D, 2, 700, 4);
    bench.enable();
    for (int k = 0; k < 60; ++k) {
        bench.cycle(0x0F, 15 * k);
    }
    for (int k = 0; k < 30; ++k) {
        bench.cycle(0x0F, 900);
    }
    EXPECT_EQ(bench.read(0x6064), 900); // position unknown: no limits yet
    bench.write(0x607C, 0, 600, 4);
    bench.write(0x6098, 0, 37, 1);
    bench.write(0x6060, 0, 6, 1);
    bench.cycle(0x1F, 600);
    bench.cycle(0x1F, 600);
    bench.write(0x6060, 0, 8, 1);
    ASSERT_TRUE(bench.drive().homed());
    for (int k = 0; k < 100; ++k) {
        bench.cycle(0x0F, 600 + 5 * k);
    }
    EXPECT_EQ(bench.read(0x6064), 700);
    EXPECT_EQ(bench.statusword() & 0x800, 0x800);
    for (int k = 0; k < 60; ++k) {
        bench.cycle(0x0F, 650);
    }
    EXPECT_EQ(bench.read(0x6064), 650);
    EXPECT_EQ(bench.statusword() & 0x800, 0);
}

TEST(Drive, quick_stop_brakes_with_its_deceleration) {
    Bench bench(Bench::standard());
    bench.write(0x6085, 0, 222222, 4);
    bench.write(0x605A, 0, 6, 2);
    bench.enable();
    run_up(bench, 200);
    const double start = bench.drive().true_position_counts(bench.scheduler.now_ns());
    const double speed = bench.drive().true_velocity_counts_per_s();
    bench.write(0x6040, 0, 0x02, 2);
    bench.run_ms(500);
    EXPECT_NEAR(bench.drive().true_velocity_counts_per_s(), 0.0, 1.0e-6);
    EXPECT_EQ(state_bits(bench.statusword()), 0x07);
    EXPECT_TRUE(bench.drive().energised());
    // The set-point leads by 2 v / w and brakes over v^2 / 2a; SDO, arbitration and the loop's step take under 3 ms, in
    // which the last target of the cycle is reached anyway.
    const double distance = bench.drive().true_position_counts(bench.scheduler.now_ns()) - start;
    EXPECT_GT(distance, 2.0 * speed / omega_rad_per_s - 2.0);
    EXPECT_LT(distance, 2.0 * speed / omega_rad_per_s + speed * speed / (2.0 * 222222.0) + speed * 3.0e-3);
}

TEST(Drive, profile_position_moves_by_the_handshake) {
    Bench bench(Bench::standard());
    bench.write(0x6060, 0, 1, 1);
    for (const int controlword : {0x06, 0x07, 0x0F}) {
        bench.write(0x6040, 0, controlword, 2);
    }
    bench.write(0x607A, 0, -20000, 4);
    bench.write(0x6040, 0, 0x1F, 2);
    EXPECT_EQ(bench.statusword() & 0x1400, 0x1000);
    bench.write(0x6040, 0, 0x0F, 2);
    bench.run_ms(4000);
    EXPECT_EQ(bench.statusword() & 0x1400, 0x0400);
    EXPECT_EQ(bench.read(0x6064), -20000);
    bench.write(0x607A, 0, 500, 4);
    bench.write(0x6040, 0, 0x5F, 2); // relative
    bench.run_ms(1000);
    EXPECT_EQ(bench.read(0x6064), -19500);
}

Drive_config arm_elevation() {
    Drive_config config = Bench::standard();
    config.brake = true;
    config.friction_counts_per_s2 = 2.0e4;
    config.gravity_counts_per_s2 = -1.0e5;
    return config;
}

TEST(Brake, holds_a_gravity_axis_through_enabling_and_disabling) {
    Bench bench(arm_elevation());
    double lowest = 0.0;
    const auto watch = [&](int duration_ms) {
        for (int k = 0; k < duration_ms; ++k) {
            bench.run_ms(1);
            lowest = std::min(lowest, bench.drive().true_position_counts(bench.scheduler.now_ns()));
        }
    };
    watch(200);
    EXPECT_TRUE(bench.drive().brake_closed());
    bench.enable();
    watch(100);
    EXPECT_FALSE(bench.drive().brake_closed());
    EXPECT_TRUE(bench.drive().energised());
    bench.write(0x6040, 0, 0x06, 2);
    watch(200);
    EXPECT_TRUE(bench.drive().brake_closed());
    EXPECT_FALSE(bench.drive().energised());
    EXPECT_GT(lowest, -1.0e-6);
}

TEST(Brake, opens_after_its_delay_and_set_points_wait_for_it) {
    Bench bench(arm_elevation());
    bench.map_cycle();
    bench.write(0x6060, 0, 8, 1);
    bench.nmt(0x01);
    for (const std::uint16_t controlword : {0x06, 0x06, 0x07, 0x07, 0x0F, 0x0F}) {
        bench.cycle(controlword, 0);
    }
    for (int k = 0; k < 15; ++k) { // 30 of 40 ms
        EXPECT_TRUE(bench.drive().brake_closed());
        EXPECT_EQ(bench.drive().statusword() & 0x1000, 0);
        bench.cycle(0x0F, 20);
    }
    EXPECT_NEAR(bench.drive().true_position_counts(bench.scheduler.now_ns()), 0.0, 1.0e-9);
    for (int k = 0; k < 40; ++k) {
        bench.cycle(0x0F, 20);
    }
    EXPECT_EQ(bench.drive().statusword() & 0x1000, 0x1000);
    EXPECT_NEAR(bench.drive().true_position_counts(bench.scheduler.now_ns()), 20.0, 0.1);
}

TEST(Brake, after_sto_the_axis_falls_until_the_brake_has_closed) {
    Bench bench(arm_elevation());
    bench.enable();
    bench.run_ms(100);
    bench.drive().set_sto(false);
    bench.run_ms(300);
    const double fall = -bench.drive().true_position_counts(bench.scheduler.now_ns());
    EXPECT_TRUE(bench.drive().brake_closed());
    // Free fall for 30 ms at (gravity - friction), give or take a step, then the brake's deceleration.
    EXPECT_GT(fall, 0.5 * 8.0e4 * 0.028 * 0.028);
    EXPECT_LT(fall, 0.5 * 8.0e4 * 0.033 * 0.033 * (1.0 + 8.0e4 / 9.0e5));
}

TEST(Brake, can_be_demanded_by_digital_output_1) {
    Bench bench(arm_elevation());
    bench.enable();
    bench.run_ms(100);
    bench.write(0x60FE, 2, 1, 4);
    EXPECT_FALSE(bench.drive().brake_closed());
    bench.write(0x60FE, 1, 1, 4);
    EXPECT_TRUE(bench.drive().brake_closed());
    bench.write(0x60FE, 1, 0, 4);
    EXPECT_FALSE(bench.drive().brake_closed());
}

} // namespace
} // namespace gonio::sim
