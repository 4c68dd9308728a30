// test_elementary.cpp: sine, exponential and their kin against the C library over dense random arguments, and against
// bits that no machine may change.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "elementary.hpp"

namespace gonio::sim {
namespace {

constexpr double tolerance = 1e-14;
constexpr int arguments = 200000;

// Largest error of `ours` against the C library, relative to the value or, where that is smaller, to `floor`.
template <typename Ours, typename Theirs>
double worst(double least, double most, double floor, const Ours &ours, const Theirs &theirs) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> draw(least, most);
    double error = 0.0;
    for (int i = 0; i < arguments; ++i) {
        double const x = draw(random);
        double const exact = theirs(x);
        double const value = ours(x);
        double const off = value == exact ? 0.0 : std::abs(value - exact) / std::max(std::abs(exact), floor);
        error = off >= 0.0 ? std::max(error, off) : 1.0; // no number: as bad as can be
    }
    return error;
}

// Their argument is rounded, so near a zero of theirs only the absolute error means something.
TEST(Elementary, sine_and_cosine_of_turns) {
    auto const angle = [](double turns) { return 2.0L * std::numbers::pi_v<long double> * turns; };
    auto const sine = [](double t) { return sine_cosine_of_turns(t).sine; };
    auto const cosine = [](double t) { return sine_cosine_of_turns(t).cosine; };
    auto const c_sine = [&](double t) { return static_cast<double>(std::sin(angle(t))); };
    auto const c_cosine = [&](double t) { return static_cast<double>(std::cos(angle(t))); };
    EXPECT_LT(worst(-1.0, 2.0, 1e-3, sine, c_sine), tolerance);
    EXPECT_LT(worst(-1.0, 2.0, 1e-3, cosine, c_cosine), tolerance);
    EXPECT_LT(worst(-1e-9, 1e-9, 0.0, sine, c_sine), tolerance);
}

TEST(Elementary, whole_quarters_of_a_turn_are_exact) {
    for (int quarter = -4; quarter <= 8; ++quarter) {
        auto const turn = sine_cosine_of_turns(0.25 * quarter);
        int const q = (quarter + 4) % 4;
        EXPECT_EQ(turn.sine, q == 1 ? 1.0 : q == 3 ? -1.0 : 0.0) << quarter;
        EXPECT_EQ(turn.cosine, q == 0 ? 1.0 : q == 2 ? -1.0 : 0.0) << quarter;
    }
}

TEST(Elementary, sine_and_cosine) {
    auto const sine = [](double x) { return sine_cosine(x).sine; };
    auto const cosine = [](double x) { return sine_cosine(x).cosine; };
    auto const c_sine = [](double x) { return std::sin(x); };
    auto const c_cosine = [](double x) { return std::cos(x); };
    for (double const most : {1e-6, 1.0, 10.0, 1e4}) {
        EXPECT_LT(worst(-most, most, 1e-6, sine, c_sine), tolerance) << most;
        EXPECT_LT(worst(-most, most, 1e-6, cosine, c_cosine), tolerance) << most;
    }
}

TEST(Elementary, exponential) {
    auto const c = [](double x) { return std::exp(x); };
    for (double const most : {1e-8, 1.0, 40.0, 707.0}) {
        EXPECT_LT(worst(-most, most, 0.0, exponential, c), tolerance) << most;
    }
    EXPECT_EQ(exponential(0.0), 1.0);
    EXPECT_EQ(exponential(-1000.0), 0.0);
    EXPECT_EQ(exponential(1000.0), std::numeric_limits<double>::infinity());
}

TEST(Elementary, logarithm) {
    auto const c = [](double x) { return std::log(x); };
    EXPECT_LT(worst(0x1p-33, 1.0, 0.0, logarithm, c), tolerance);
    EXPECT_LT(worst(0.999, 1.001, 0.0, logarithm, c), tolerance);
    EXPECT_LT(worst(1.0, 1e300, 0.0, logarithm, c), tolerance);
    EXPECT_LT(worst(0.0, 1e-310, 0.0, logarithm, c), tolerance);
    EXPECT_EQ(logarithm(1.0), 0.0);
}

TEST(Elementary, arc_tangent) {
    for (double const x : {-1e3, -1.0, -1e-3, 1e-3, 1.0, 1e3}) {
        auto const ours = [x](double y) { return arc_tangent(y, x); };
        auto const c = [x](double y) { return std::atan2(y, x); };
        EXPECT_LT(worst(-1.0, 1.0, 0.0, ours, c), tolerance) << x;
    }
    for (double const y : {-1.0, -0.0, 0.0, 1.0}) {
        for (double const x : {-1.0, -0.0, 0.0, 1.0}) {
            double const exact = std::atan2(y, x);
            EXPECT_NEAR(arc_tangent(y, x), exact, 1e-15) << y << " " << x;
            EXPECT_EQ(std::signbit(arc_tangent(y, x)), std::signbit(exact)) << y << " " << x;
        }
    }
}

TEST(Elementary, arc_cosine) {
    auto const c = [](double x) { return std::acos(x); };
    EXPECT_LT(worst(-1.0, 1.0, 0.0, arc_cosine, c), tolerance);
    EXPECT_LT(worst(1.0 - 1e-12, 1.0, 0.0, arc_cosine, c), tolerance);
    EXPECT_LT(worst(-1e-9, 1e-9, 0.0, arc_cosine, c), tolerance);
    EXPECT_EQ(arc_cosine(1.5), 0.0);
    EXPECT_NEAR(arc_cosine(-1.5), std::numbers::pi, 1e-15);
}

// All bits of all functions over fixed arguments in one number: any machine, compiler and optimisation gives it.
TEST(Elementary, bits_are_those_of_every_machine) {
    std::uint64_t sum = 0;
    auto const add = [&](double value) { sum = sum * 0x9E3779B97F4A7C15U + std::bit_cast<std::uint64_t>(value); };
    for (int i = 1; i < 20000; ++i) {
        double const x = i * 0x1.3p-14; // up to 1.45
        add(sine_cosine_of_turns(x).sine);
        add(sine_cosine_of_turns(-0.5 * x).cosine);
        add(sine_cosine(1000.0 * x).sine);
        add(sine_cosine(-3.0 * x).cosine);
        add(exponential(-20.0 * x));
        add(logarithm(x));
        add(arc_tangent(x, 0.7 - x));
        add(arc_cosine(x - 0.7));
    }
    EXPECT_EQ(sum, 2280316840102415475U);
}

} // namespace
} // namespace gonio::sim
