// test_bernstein.cpp: values, halving and bounds of Bernstein polynomials against dense sampling.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

extern "C" {
#include "bernstein.h"
}

namespace {

// B_i(u) = C(5, i) u^i (1 - u)^(5 - i), summed as the definition says.
double by_definition(const std::array<double, 6> &c, double u) {
    constexpr std::array<double, 6> binomial = {1, 5, 10, 10, 5, 1};
    double sum = 0.0;
    for (int i = 0; i < 6; i++) {
        sum += c[i] * binomial[i] * std::pow(u, i) * std::pow(1.0 - u, 5 - i);
    }
    return sum;
}

std::array<double, 6> random_coefficients(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> value(-1000.0, 1000.0);
    std::array<double, 6> c{};
    std::generate(c.begin(), c.end(), [&] { return value(random); });
    return c;
}

TEST(Bernstein, ValueIsTheDefinition) {
    std::mt19937_64 random(1);
    for (int trial = 0; trial < 200; trial++) {
        auto const c = random_coefficients(random);
        for (int step = 0; step <= 64; step++) {
            double const u = step / 64.0;
            EXPECT_NEAR(gn_bernstein_value(c.data(), 5, u), by_definition(c, u), 1e-9);
        }
        EXPECT_EQ(gn_bernstein_value(c.data(), 5, 0.0), c.front());
        EXPECT_EQ(gn_bernstein_value(c.data(), 5, 1.0), c.back());
    }
}

TEST(Bernstein, HalvesAreTheSameCurve) {
    std::mt19937_64 random(2);
    auto const c = random_coefficients(random);
    std::array<double, 6> left{};
    std::array<double, 6> right{};
    gn_bernstein_split(c.data(), 5, left.data(), right.data());
    for (int step = 0; step <= 64; step++) {
        double const u = step / 64.0;
        EXPECT_NEAR(by_definition(left, u), by_definition(c, 0.5 * u), 1e-9);
        EXPECT_NEAR(by_definition(right, u), by_definition(c, 0.5 + 0.5 * u), 1e-9);
    }
}

TEST(Bernstein, BoundsAreNeverNarrowerAndAtMostTheToleranceWider) {
    std::mt19937_64 random(3);
    constexpr double tolerance = 0.01;
    for (int trial = 0; trial < 500; trial++) {
        auto const c = random_coefficients(random);
        gn_range const bounds = gn_bernstein_bounds(c.data(), 5, tolerance);
        double low = c[0];
        double high = c[0];
        for (int i = 0; i <= 20000; i++) {
            double const value = gn_bernstein_value(c.data(), 5, i / 20000.0);
            low = std::min(low, value);
            high = std::max(high, value);
        }
        EXPECT_LE(bounds.low, low);
        EXPECT_GE(bounds.high, high);
        // 20000 samples miss an extremum by less than c'' / (8 n^2), far below the tolerance.
        EXPECT_GE(bounds.low, low - 1.01 * tolerance);
        EXPECT_LE(bounds.high, high + 1.01 * tolerance);
    }
}

TEST(Bernstein, BoundsOfAParabola) {
    // 4 u (1 - u) in degree 2: coefficients 0, 2, 0; its hull says 2, its top is 1.
    double const c[] = {0.0, 2.0, 0.0};
    EXPECT_EQ(gn_bernstein_hull(c, 2).high, 2.0);
    gn_range const bounds = gn_bernstein_bounds(c, 2, 1e-9);
    EXPECT_NEAR(bounds.high, 1.0, 1e-9);
    EXPECT_EQ(bounds.low, 0.0);
}

TEST(Bernstein, BoundsOfAConstantEndAtOnceAtAnyScale) {
    std::array<double, 6> c{};
    c.fill(1e30 / 3.0);
    gn_range const bounds = gn_bernstein_bounds(c.data(), 5, 1e-9);
    EXPECT_DOUBLE_EQ(bounds.low, 1e30 / 3.0);
    EXPECT_DOUBLE_EQ(bounds.high, 1e30 / 3.0);
}

} // namespace
