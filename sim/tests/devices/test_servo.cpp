// test_servo.cpp: the axis against closed forms: step, ramp and limited responses, friction, brake, smoothness.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "ramp.hpp"
#include "servo.hpp"
#include "set_points.hpp"

namespace gonio::sim {
namespace {

constexpr double omega = 2.0 * std::numbers::pi * 50.0;

Servo_config strong() {
    Servo_config config;
    config.max_acceleration_counts_per_s2 = 1.0e12;
    return config;
}

TEST(Servo, answers_a_step_as_a_critically_damped_system_of_second_order) {
    Servo servo(strong(), 0.0, 0);
    for (int k = 1; k <= 60; ++k) {
        servo.step({true, false, false, 1000.0, 1000.0});
        const double t = 1.0e-3 * k;
        const double expected = 1000.0 * (1.0 - (1.0 + omega * t) * std::exp(-omega * t));
        EXPECT_NEAR(servo.position_counts(servo.end_ns()), expected, 1.0e-8);
        EXPECT_NEAR(servo.velocity_counts_per_s(servo.end_ns()), 1000.0 * omega * omega * t * std::exp(-omega * t),
                    1.0e-6);
    }
}

TEST(Servo, follows_a_ramp_with_a_lag_of_two_time_constants) {
    Servo servo(strong(), 0.0, 0);
    constexpr double speed = 30.0 * 10000.0 / 9.0;
    for (int k = 0; k < 100; ++k) {
        servo.step({true, false, false, speed * 1.0e-3 * k, speed * 1.0e-3 * (k + 1)});
        const double t = 1.0e-3 * (k + 1);
        const double decay = std::exp(-omega * t);
        EXPECT_NEAR(servo.end_position_counts(), speed * (t - 2.0 / omega + (t + 2.0 / omega) * decay), 1.0e-8);
    }
    EXPECT_NEAR(speed * 0.1 - servo.end_position_counts(), speed * 2.0 / omega, 1.0e-6);
}

TEST(Servo, between_steps_the_cubic_is_within_its_error_bound_of_the_true_response) {
    Servo servo(strong(), 0.0, 0);
    for (int k = 0; k < 30; ++k) {
        servo.step({true, false, false, 1000.0, 1000.0});
    }
    for (std::int64_t time_ns = 0; time_ns <= servo.end_ns(); time_ns += 37'000) {
        const double t = 1.0e-9 * static_cast<double>(time_ns);
        const double expected = 1000.0 * (1.0 - (1.0 + omega * t) * std::exp(-omega * t));
        // Cubic Hermite: h^4 / 384 * max |x''''|, and |x''''| <= 3 w^4 * 1000 here.
        EXPECT_NEAR(servo.position_counts(time_ns), expected, 1.0e-12 / 384.0 * 3.0e3 * std::pow(omega, 4.0));
    }
}

TEST(Servo, position_and_velocity_are_continuous_and_remembered_for_63_ms) {
    Servo servo(Servo_config{}, 123.25, 5'000'000);
    EXPECT_EQ(servo.position_counts(0), 123.25);
    for (int k = 0; k < 200; ++k) {
        const double angle = 0.05 * k;
        servo.step({true, false, false, 123.25 + 500.0 * std::sin(angle), 123.25 + 500.0 * std::sin(angle + 0.05)});
    }
    for (std::int64_t node_ns = servo.end_ns() - 62 * Servo::step_ns; node_ns < servo.end_ns();
         node_ns += Servo::step_ns) {
        EXPECT_NEAR(servo.position_counts(node_ns - 1), servo.position_counts(node_ns + 1), 1.0e-3);
        EXPECT_NEAR(servo.velocity_counts_per_s(node_ns - 1), servo.velocity_counts_per_s(node_ns + 1), 2.0);
    }
    const double oldest = servo.position_counts(servo.end_ns() - 63 * Servo::step_ns);
    EXPECT_EQ(servo.position_counts(0), oldest);
    EXPECT_EQ(servo.position_counts(servo.end_ns() + 1'000'000), servo.end_position_counts());
}

TEST(Servo, never_accelerates_beyond_its_limit) {
    Servo_config config;
    config.max_acceleration_counts_per_s2 = 2.0e5;
    Servo servo(config, 0.0, 0);
    double velocity = 0.0;
    for (int k = 0; k < 2000; ++k) {
        servo.step({true, false, false, 20000.0, 20000.0});
        EXPECT_LE(std::abs(servo.end_velocity_counts_per_s() - velocity), 2.0e5 * 1.0e-3 + 1.0e-6);
        velocity = servo.end_velocity_counts_per_s();
    }
    EXPECT_NEAR(servo.end_position_counts(), 20000.0, 1.0);
}

TEST(Servo, without_torque_friction_stops_it_where_energy_says) {
    Servo servo(strong(), 0.0, 0);
    for (int k = 0; k < 100; ++k) {
        servo.step({true, false, false, 30.0 * k, 30.0 * (k + 1)});
    }
    const double start = servo.end_position_counts();
    const double speed = servo.end_velocity_counts_per_s();
    for (int k = 0; k < 300; ++k) {
        servo.step({});
    }
    EXPECT_EQ(servo.end_velocity_counts_per_s(), 0.0);
    EXPECT_NEAR(servo.end_position_counts() - start, speed * speed / (2.0 * 3.0e5), 1.0e-6);
}

TEST(Servo, a_brake_holds_against_gravity_and_gravity_wins_without) {
    Servo_config config;
    config.friction_counts_per_s2 = 1.0e4;
    config.gravity_counts_per_s2 = -5.0e4;
    Servo servo(config, 0.0, 0);
    servo.step({false, true, false, 0.0, 0.0});
    EXPECT_EQ(servo.end_position_counts(), 0.0);
    for (int k = 0; k < 100; ++k) {
        servo.step({});
    }
    EXPECT_NEAR(servo.end_position_counts(), -0.5 * 4.0e4 * 0.01, 1.0e-6);
    servo.step({true, false, true, 0.0, 0.0});
    EXPECT_EQ(servo.end_velocity_counts_per_s(), 0.0);
}

TEST(Ramp, comes_to_rest_exactly_at_the_target_and_takes_the_trapezoids_time) {
    Ramp ramp;
    ramp.place(-500.0, 0.0);
    int steps = 0;
    double top = 0.0;
    while (!(ramp.at_rest() && ramp.position_counts() == 99500.0) && steps < 20000) {
        ramp.step_position(1.0e-3, 99500.0, 33333.0, 66667.0, 50000.0);
        top = std::max(top, ramp.velocity_counts_per_s());
        EXPECT_LE(ramp.position_counts(), 99500.0 + 1.0e-6);
        ++steps;
    }
    EXPECT_NEAR(top, 33333.0, 1.0e-6);
    const double expected_s = 100000.0 / 33333.0 + 0.5 * 33333.0 * (1.0 / 66667.0 + 1.0 / 50000.0);
    EXPECT_NEAR(1.0e-3 * steps, expected_s, 5.0e-3);
}

TEST(Ramp, turns_round_when_the_target_is_behind) {
    Ramp ramp;
    ramp.place(0.0, 20000.0);
    for (int k = 0; k < 3000; ++k) {
        ramp.step_position(1.0e-3, -1000.0, 10000.0, 50000.0, 50000.0);
    }
    EXPECT_EQ(ramp.position_counts(), -1000.0);
    EXPECT_TRUE(ramp.at_rest());
}

TEST(Interpolator, reaches_the_target_after_one_period_and_waits_there) {
    Interpolator interpolator;
    interpolator.hold(100.0);
    interpolator.take(1'000'000, 300.0, 2'000'000);
    EXPECT_EQ(interpolator.at(2'250'000), 100.0); // a step and an eighth of the period later
    EXPECT_EQ(interpolator.at(3'750'000), 250.0);
    EXPECT_EQ(interpolator.at(9'000'000), 300.0);
    interpolator.take(9'000'000, 0.0, 2'000'000); // long after: a new grid
    EXPECT_EQ(interpolator.at(10'250'000), 300.0);
    EXPECT_EQ(interpolator.at(11'250'000), 150.0);
}

TEST(Interpolator, sync_jitter_does_not_become_velocity) {
    Interpolator interpolator;
    interpolator.hold(0.0);
    std::uint32_t random = 7;
    double before = 0.0;
    for (std::int64_t k = 0; k < 500; ++k) {
        random = random * 1664525U + 1013904223U;
        const std::int64_t jitter_ns = static_cast<std::int64_t>(random >> 12U) % 120'000;
        interpolator.take(2'000'000 * k + jitter_ns, 60.0 * static_cast<double>(k + 1), 2'000'000);
        for (std::int64_t part = 1; part <= 4; ++part) { // 15 counts in each quarter of a period
            const double now = interpolator.at(2'000'000 * k + 120'000 + 500'000 * (part - 1));
            if (k > 100) {
                EXPECT_NEAR(now - before, 15.0, 1.0);
            }
            before = now;
        }
    }
}

// An axis' steps and SYNCs in their order in time; a SYNC carries the path's place one period later.
struct Follower {
    std::int64_t period_ns, phase_ns, jitter_ns;
    int lost_every = 0; // this one of so many SYNCs is lost

    // The path less the axis' place at the end of each of the steps, counts.
    template <typename Path> std::vector<double> lags(const Path &path_counts, int steps) const {
        Interpolator interpolator;
        Servo servo(Servo_config{}, 0.0, 0);
        interpolator.hold(0.0);
        std::vector<double> lags;
        std::uint32_t random = 11;
        std::int64_t sync = 0;
        std::int64_t sync_ns = phase_ns;
        double demand = 0.0;
        for (int k = 0; k < steps; ++k) {
            for (; sync_ns <= servo.end_ns(); ++sync) {
                if (lost_every == 0 || sync % lost_every != lost_every - 1) {
                    const std::int64_t target_ns = phase_ns + (sync + 1) * period_ns;
                    interpolator.take(sync_ns, path_counts(1.0e-9 * static_cast<double>(target_ns)), period_ns);
                }
                random = random * 1664525U + 1013904223U;
                const std::int64_t late_ns = jitter_ns == 0 ? 0 : static_cast<std::int64_t>(random >> 8U) % jitter_ns;
                sync_ns = phase_ns + (sync + 1) * period_ns + late_ns;
            }
            const double next = interpolator.at(servo.end_ns() + Servo::step_ns);
            servo.step({true, false, false, demand, next});
            demand = next;
            lags.push_back(path_counts(1.0e-9 * static_cast<double>(servo.end_ns())) - servo.end_position_counts());
        }
        return lags;
    }
};

double largest(std::vector<double>::const_iterator begin, std::vector<double>::const_iterator end) {
    return std::abs(*std::max_element(begin, end, [](double a, double b) { return std::abs(a) < std::abs(b); }));
}

constexpr double top_speed = 30.0 * 10000.0 / 9.0;

TEST(Follower, sync_jitter_of_120_us_costs_its_own_way_and_no_more) {
    const auto path = [](double t) { return 0.5 * top_speed * (1.0 - std::cos(2.0 * t)); };
    for (const std::int64_t period_ns : {1'000'000, 2'000'000, 5'000'000}) {
        for (std::int64_t phase_ns = 0; phase_ns < 2'000'000; phase_ns += 200'000) {
            const auto steady = Follower{period_ns, phase_ns, 0}.lags(path, 10'000);
            const auto jittery = Follower{period_ns, phase_ns, 120'000}.lags(path, 10'000);
            const double delay_s = 2.0e-9 * static_cast<double>(period_ns) + 1.0e-3 + 2.0 / omega;
            EXPECT_LT(largest(steady.begin(), steady.end()), top_speed * delay_s);
            for (std::size_t k = 0; k < steady.size(); ++k) {
                ASSERT_NEAR(jittery[k], steady[k], top_speed * 120.0e-6 + 1.0)
                    << "phase " << phase_ns << ", step " << k;
            }
        }
    }
}

// A lost SYNC is a step of two periods' way, far more than the linear law takes without limit.
TEST(Follower, lost_syncs_do_not_add_up_to_a_growing_lag) {
    const auto path = [](double t) { return top_speed * std::max(0.0, t - 0.5 * (1.0 - std::exp(-2.0 * t))); };
    for (std::int64_t phase_ns = 0; phase_ns < 2'000'000; phase_ns += 200'000) {
        const auto whole = Follower{2'000'000, phase_ns, 120'000}.lags(path, 20'000);
        for (const int lost_every : {5, 25, 100}) {
            const auto lossy = Follower{2'000'000, phase_ns, 120'000, lost_every}.lags(path, 20'000);
            const double early = largest(lossy.begin() + 3'000, lossy.begin() + 6'000);
            EXPECT_LE(largest(lossy.end() - 3'000, lossy.end()), early + 5.0);
            EXPECT_LE(early, largest(whole.begin(), whole.end()) + 4.0 * 2.0e-3 * top_speed) << lost_every;
        }
    }
}

TEST(Profile_position, set_points_are_taken_acknowledged_and_queued) {
    Profile_position profile;
    Ramp ramp;
    const Profile_position::Limits limits{50000.0, 100000.0, 100000.0};
    profile.reset(0.0);
    const auto run = [&](int steps) {
        for (int k = 0; k < steps; ++k) {
            profile.step(1.0e-3, limits, false, ramp);
        }
    };
    profile.command(true, false, 1000.0);
    EXPECT_TRUE(profile.acknowledged());
    profile.command(false, false, 1000.0);
    EXPECT_FALSE(profile.acknowledged());
    run(20);
    profile.command(true, false, 3000.0); // while moving: afterwards
    profile.command(false, false, 3000.0);
    EXPECT_TRUE(profile.acknowledged()); // the buffer is full
    profile.command(true, true, 9000.0); // and takes no more
    run(2000);
    EXPECT_EQ(ramp.position_counts(), 3000.0);
    EXPECT_TRUE(profile.reached());
    profile.command(false, false, 0.0);
    profile.command(true, false, -5000.0);
    run(30);
    profile.command(false, false, 0.0);
    profile.command(true, true, 500.0); // at once
    run(2000);
    EXPECT_EQ(ramp.position_counts(), 500.0);
    profile.command(false, false, 0.0);
    profile.command(true, false, 4000.0);
    run(50);
    for (int k = 0; k < 500; ++k) {
        profile.step(1.0e-3, limits, true, ramp); // halt
    }
    EXPECT_TRUE(ramp.at_rest());
    EXPECT_LT(ramp.position_counts(), 4000.0);
    run(2000);
    EXPECT_EQ(ramp.position_counts(), 4000.0);
}

} // namespace
} // namespace gonio::sim
