// elementary.hpp: sine, exponential and their kin from additions and multiplications alone, so that a photon's path has
// the same bits on every machine (the C library picks other code on other processors). Relative error below 1e-14.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace gonio::sim {

struct Sine_cosine {
    double sine;
    double cosine;
};

namespace elementary {

// Sum of c[i], c[i + 2], ... times 1, x2, x2^2, ...
template <std::size_t i, std::size_t n> inline double every_second(const std::array<double, n> &c, double x2) {
    if constexpr (i + 2 < n) {
        return c[i] + x2 * every_second<i + 2>(c, x2);
    } else {
        return c[i];
    }
}

// Even and odd powers apart: half the chain of Horner's rule.
template <std::size_t n> inline double polynomial(const std::array<double, n> &c, double x) {
    return every_second<0>(c, x * x) + x * every_second<1>(c, x * x);
}

// The nearest whole number, as a number and in the low bits of a word. |x| < 2^51.
struct Nearest {
    double value;
    std::uint64_t bits;
};
inline Nearest nearest(double x) {
    constexpr double shift = 0x1.8p52; // beyond it a double has no fraction, and its low bits count
    double const shifted = x + shift;
    return {shifted - shift, std::bit_cast<std::uint64_t>(shifted)};
}

// Taylor series, after the terms that are written out: of sine / x - 1 in x^2, of cosine - 1 + x^2 / 2 in x^2 (both up
// to pi / 4), of the exponential (up to ln 2 / 2), of 2 artanh (up to 0.172).
inline constexpr std::array sine_series = {-1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,         1.0 / 362880.0,
                                           -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0};
inline constexpr std::array cosine_series = {
    1.0 / 24.0,        -1.0 / 720.0,         1.0 / 40320.0,         -1.0 / 3628800.0,
    1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};
inline constexpr std::array exponential_series = {
    1.0 / 2.0,     1.0 / 6.0,      1.0 / 24.0,      1.0 / 120.0,      1.0 / 720.0,       1.0 / 5040.0,
    1.0 / 40320.0, 1.0 / 362880.0, 1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0};
inline constexpr std::array logarithm_series = {2.0 / 3.0,  2.0 / 5.0,  2.0 / 7.0,  2.0 / 9.0,  2.0 / 11.0,
                                                2.0 / 13.0, 2.0 / 15.0, 2.0 / 17.0, 2.0 / 19.0, 2.0 / 21.0};
// arctan(t) / t in t^2 up to tan(pi / 8): interpolated at Chebyshev's points, error 1e-18.
inline constexpr std::array arc_tangent_series = {1.0,
                                                  -0.3333333333333312,
                                                  0.19999999999940887,
                                                  -0.14285714279249936,
                                                  0.1111111074490436,
                                                  -0.09090896808621685,
                                                  0.07692045322957222,
                                                  -0.06662951722276356,
                                                  0.05846877624500781,
                                                  -0.050350993874287,
                                                  0.03796517852008574,
                                                  -0.017805309727847867};

// Of quarter turns and a rest of at most pi / 4.
inline Sine_cosine of_quadrant(double rest_rad, std::uint64_t quarter_turns) {
    double const x2 = rest_rad * rest_rad;
    auto const sine = std::bit_cast<std::uint64_t>(rest_rad + rest_rad * (x2 * polynomial(sine_series, x2)));
    auto const cosine = std::bit_cast<std::uint64_t>((1.0 - 0.5 * x2) + x2 * (x2 * polynomial(cosine_series, x2)));
    // Swapped in odd quadrants, without a branch: the quadrant is as random as the photon.
    std::uint64_t const swap = (sine ^ cosine) & (std::uint64_t{0} - (quarter_turns & 1U));
    return {std::bit_cast<double>(sine ^ swap ^ ((quarter_turns & 2U) << 62U)),
            std::bit_cast<double>(cosine ^ swap ^ (((quarter_turns + 1U) & 2U) << 62U))};
}

inline constexpr double pi = 0x1.921fb54442d18p+1;

} // namespace elementary

// Of a fraction of a turn, -1 to 2.
inline Sine_cosine sine_cosine_of_turns(double turns) {
    auto const quarters = elementary::nearest(4.0 * turns);
    return elementary::of_quadrant(2.0 * elementary::pi * (turns - 0.25 * quarters.value), quarters.bits);
}

// Of an angle, magnitude below 1e4 rad.
inline Sine_cosine sine_cosine(double angle_rad) {
    // A quarter turn in three parts; the products with the first two are exact (Cody and Waite 1980).
    constexpr double quarter_1 = 0x1.921fb544p+0;
    constexpr double quarter_2 = 0x1.0b4611a6p-34;
    constexpr double quarter_3 = 0x1.3198a2e037073p-69;
    auto const quarters = elementary::nearest(angle_rad * 0x1.45f306dc9c883p-1);
    double const rest =
        ((angle_rad - quarters.value * quarter_1) - quarters.value * quarter_2) - quarters.value * quarter_3;
    return elementary::of_quadrant(rest, quarters.bits);
}

// Below -708: 0; above 709: infinity.
inline double exponential(double x) {
    if (x < -708.0) {
        return 0.0;
    }
    if (x > 709.0) {
        return std::numeric_limits<double>::infinity();
    }
    auto const doublings = elementary::nearest(x * 0x1.71547652b82fep+0);
    double const rest = (x - doublings.value * 0x1.62e42fefa2p-1) - doublings.value * 0x1.9ef35793c7673p-41;
    double const power = 1.0 + (rest + rest * rest * elementary::polynomial(elementary::exponential_series, rest));
    return power * std::bit_cast<double>((doublings.bits + 1023U) << 52U);
}

// x > 0.
inline double logarithm(double x) {
    double doublings = 0.0;
    if (x < std::numeric_limits<double>::min()) {
        x *= 0x1p54;
        doublings = -54.0;
    }
    // Between the square roots of 1/2 and 2, where (m - 1) / (m + 1) is at most 0.172.
    auto const bits = std::bit_cast<std::uint64_t>(x);
    constexpr auto least = std::bit_cast<std::uint64_t>(0x1.6a09e667f3bcdp-1);
    std::int64_t const exponent = static_cast<std::int64_t>(bits - least) >> 52U;
    double const m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(exponent) << 52U));
    doublings += static_cast<double>(exponent);
    double const s = (m - 1.0) / (m + 1.0);
    double const s2 = s * s;
    double const series = 2.0 * s + s * (s2 * elementary::polynomial(elementary::logarithm_series, s2));
    return doublings * 0x1.62e42fefa2p-1 + (series + doublings * 0x1.9ef35793c7673p-41);
}

// In [-pi, pi], the convention of std::atan2, signs of zeros included.
inline double arc_tangent(double y, double x) {
    double const ax = std::abs(x);
    double const ay = std::abs(y);
    double const most = std::max(ax, ay);
    double const least = std::min(ax, ay);
    // Up to tan(pi / 8) as it is, above as pi / 4 + arctan((t - 1) / (t + 1)).
    bool const steep = least > 0x1.a827999fcef32p-2 * most;
    double const t = (steep ? least - most : least) / std::max(steep ? least + most : most, 0x1p-1022);
    double const t2 = t * t;
    double angle =
        t * elementary::polynomial(elementary::arc_tangent_series, t2) + (steep ? elementary::pi / 4.0 : 0.0);
    angle = ay > ax ? elementary::pi / 2.0 - angle : angle;
    return std::copysign(std::signbit(x) ? elementary::pi - angle : angle, y);
}

// x in [-1, 1], clamped.
inline double arc_cosine(double x) {
    double const within = std::clamp(x, -1.0, 1.0);
    return arc_tangent(std::sqrt((1.0 - within) * (1.0 + within)), within);
}

} // namespace gonio::sim
