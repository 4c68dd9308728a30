// test_quintic.cpp: quintic segments against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

extern "C" {
#include "quintic.h"
}

namespace {

// A polynomial of degree 5 in time is its own Hermite interpolant.
struct Polynomial {
    double c[6];
    [[nodiscard]] gn_state at(double t) const {
        gn_state state{};
        for (int i = 5; i >= 0; i--) {
            state.position = state.position * t + c[i];
            if (i >= 1) {
                state.velocity = state.velocity * t + i * c[i];
            }
            if (i >= 2) {
                state.acceleration = state.acceleration * t + i * (i - 1) * c[i];
            }
        }
        return state;
    }
};

TEST(Quintic, ReproducesAnyPolynomialOfDegreeFive) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> value(-50.0, 50.0);
    for (int trial = 0; trial < 100; trial++) {
        Polynomial polynomial{};
        for (double &c : polynomial.c) {
            c = value(random);
        }
        double const duration = 0.02 + 0.05 * trial;
        gn_state const from = polynomial.at(0.0);
        gn_state const to = polynomial.at(duration);
        gn_quintic const segment = gn_quintic_join(&from, &to, duration);
        for (int i = 0; i <= 32; i++) {
            double const t = duration * i / 32.0;
            gn_state const expected = polynomial.at(t);
            gn_state const got = gn_quintic_state(&segment, t);
            EXPECT_NEAR(got.position, expected.position, 1e-9 * (1.0 + std::fabs(expected.position)));
            EXPECT_NEAR(got.velocity, expected.velocity, 1e-9 * (1.0 + std::fabs(expected.velocity)) + 1e-9);
            EXPECT_NEAR(got.acceleration, expected.acceleration, 1e-7 * (1.0 + std::fabs(expected.acceleration)));
        }
    }
}

TEST(Quintic, RestToRestIsTheMinimumJerkPolynomial) {
    // 10 u^3 - 15 u^4 + 6 u^5; its largest speed is 15/8 and its largest acceleration 10/sqrt(3) of the mean's.
    gn_state const from{100.0, 0.0, 0.0};
    gn_state const to{1100.0, 0.0, 0.0};
    gn_quintic const segment = gn_quintic_join(&from, &to, 2.0);
    EXPECT_NEAR(gn_quintic_state(&segment, 1.0).velocity, 1000.0 / 2.0 * 15.0 / 8.0, 1e-9);
    double velocity[5];
    double acceleration[4];
    gn_quintic_velocity(&segment, velocity);
    gn_quintic_acceleration(&segment, acceleration);
    EXPECT_NEAR(gn_bernstein_bounds(velocity, 4, 1e-7).high, 1000.0 / 2.0 * 15.0 / 8.0, 1e-6);
    EXPECT_NEAR(gn_bernstein_bounds(acceleration, 3, 1e-7).high, 1000.0 / 4.0 * 10.0 / std::sqrt(3.0), 1e-6);
    EXPECT_NEAR(gn_bernstein_bounds(acceleration, 3, 1e-7).low, -1000.0 / 4.0 * 10.0 / std::sqrt(3.0), 1e-6);
}

TEST(Quintic, FollowsASinusoidWithinTheHermiteError) {
    // Error of two-point quintic Hermite: |f^(6)| h^6 / (720 * 64).
    double const w = 1.2;
    double const amplitude = 25.0 * 10000.0 / 9.0;
    double const h = 0.05;
    double const bound = amplitude * std::pow(w * h, 6) / (720.0 * 64.0);
    for (int k = 0; k < 100; k++) {
        auto const state = [&](double t) {
            return gn_state{amplitude * std::sin(w * t), amplitude * w * std::cos(w * t),
                            -amplitude * w * w * std::sin(w * t)};
        };
        gn_state const from = state(k * h);
        gn_state const to = state((k + 1) * h);
        gn_quintic const segment = gn_quintic_join(&from, &to, h);
        for (int i = 0; i <= 16; i++) {
            double const t = h * i / 16.0;
            EXPECT_NEAR(gn_quintic_state(&segment, t).position, state(k * h + t).position, bound + 1e-10);
        }
    }
}

} // namespace
