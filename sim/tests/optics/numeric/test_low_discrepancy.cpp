// test_low_discrepancy.cpp: the photons' points against what makes a Sobol sequence: strata, convergence, no bias.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "low_discrepancy.hpp"

namespace gonio::sim {
namespace {

constexpr std::size_t dimensions = Low_discrepancy::dimensions;

double fraction(std::uint32_t bits) {
    return (static_cast<double>(bits) + 0.5) * 0x1p-32;
}

// Every one of 2^12 intervals of every dimension holds one of 2^12 points, whatever the scramble; also where the index
// has bits beyond 32, and in the middle of the sequence.
TEST(Low_discrepancy, one_point_in_each_interval) {
    constexpr std::uint32_t log_points = 12;
    for (std::uint64_t const first :
         {0ULL, 1ULL << 20U, (1ULL << 32U) - (1U << log_points), 5ULL << 32U, 1ULL << 40U}) {
        Low_discrepancy points(99);
        std::vector<int> counts(dimensions << log_points);
        for (std::uint64_t n = first; n < first + (1U << log_points); ++n) {
            auto const point = points.at(n);
            for (std::size_t d = 0; d < dimensions; ++d) {
                ++counts[(d << log_points) + (point[d] >> (32U - log_points))];
            }
        }
        for (int const count : counts) {
            ASSERT_EQ(count, 1);
        }
    }
}

// In each pair of dimensions every cell of a 16 x 16 grid holds 16 of 4096 points; of the first two, which start a
// photon, every elementary rectangle of area 2^-12 holds one.
TEST(Low_discrepancy, each_pair_of_dimensions_is_stratified) {
    constexpr std::uint32_t log_points = 12;
    Low_discrepancy points(4);
    std::vector<Low_discrepancy::Point> all;
    for (std::uint64_t n = 0; n < (1U << log_points); ++n) {
        all.push_back(points.at(n));
    }
    for (std::size_t a = 0; a < dimensions; ++a) {
        for (std::size_t b = a + 1; b < dimensions; ++b) {
            std::vector<int> counts(256);
            for (auto const &point : all) {
                ++counts[((point[a] >> 28U) << 4U) + (point[b] >> 28U)];
            }
            for (int const count : counts) {
                ASSERT_EQ(count, 16) << a << " " << b;
            }
        }
    }
    for (std::uint32_t bits = 0; bits <= log_points; ++bits) {
        std::vector<int> counts(1U << log_points);
        for (auto const &point : all) {
            std::uint64_t const column = static_cast<std::uint64_t>(point[0]) >> (32U - bits);
            std::uint64_t const row = static_cast<std::uint64_t>(point[1]) >> (32U - (log_points - bits));
            ++counts[(column << (log_points - bits)) + row];
        }
        for (int const count : counts) {
            ASSERT_EQ(count, 1) << bits;
        }
    }
}

// Root mean square error, over many seeds, of the mean of a smooth function of all dimensions, and the mean over all.
struct Error {
    double rms;
    double bias;
};
Error error_of_mean(std::uint64_t count) {
    constexpr int seeds = 64;
    Error error{};
    for (int seed = 0; seed < seeds; ++seed) {
        Low_discrepancy points(1000 + static_cast<std::uint64_t>(seed));
        double sum = 0.0;
        for (std::uint64_t n = 0; n < count; ++n) {
            double product = 1.0;
            for (std::uint32_t const bits : points.at(n)) {
                product *= 1.0 + 0.5 * (fraction(bits) - 0.5);
            }
            sum += product;
        }
        double const off = sum / static_cast<double>(count) - 1.0;
        error.rms += off * off / seeds;
        error.bias += off / seeds;
    }
    error.rms = std::sqrt(error.rms);
    return error;
}

// Random points: variance (1 + 1/48)^8 - 1 = 0.179 of one, so 0.42 / sqrt(N).
TEST(Low_discrepancy, mean_of_a_smooth_function_converges_faster_than_at_random) {
    Error const few = error_of_mean(64);
    Error const many = error_of_mean(4096);
    EXPECT_LT(few.rms, 0.25 * 0.42 / 8.0);
    EXPECT_LT(many.rms, 0.03 * 0.42 / 64.0);
    // 64 times the points: error / 8 at random, / 64 is asked for.
    EXPECT_LT(many.rms, few.rms / 64.0);
    // The scramble has no bias: four standard errors of the mean over the seeds.
    EXPECT_LT(std::abs(few.bias), 4.0 * few.rms / 8.0);
    EXPECT_LT(std::abs(many.bias), 4.0 * many.rms / 8.0);
}

// Owen: two points that differ first in binary place k differ there after scrambling too, and below it half the time.
TEST(Low_discrepancy, scramble_is_nested_and_uniform) {
    constexpr int seeds = 4000;
    for (std::uint32_t place = 0; place < 8; ++place) {
        std::vector<int> flips(20);
        for (int seed = 0; seed < seeds; ++seed) {
            Low_discrepancy points(static_cast<std::uint64_t>(seed));
            // In the first dimension bit k of the index is binary place k.
            std::uint32_t const changed = points.at(5U << 10U)[0] ^ points.at((5U << 10U) ^ (1U << place))[0];
            for (std::size_t k = 0; k < flips.size(); ++k) {
                flips[k] += static_cast<int>((changed >> (31U - k)) & 1U);
            }
        }
        for (std::size_t k = 0; k < flips.size(); ++k) {
            if (k <= place) {
                ASSERT_EQ(flips[k], k < place ? 0 : seeds);
            } else {
                ASSERT_NEAR(flips[k], 0.5 * seeds, 4.5 * std::sqrt(0.25 * seeds)) << place << " " << k;
            }
        }
    }
}

TEST(Low_discrepancy, seeds_and_repetitions_have_scrambles_of_their_own) {
    Low_discrepancy points(1);
    Low_discrepancy others(2);
    auto const first = points.at(0);
    auto const repeated = points.at(1ULL << 32U);
    EXPECT_EQ(points.at(0), first);
    for (std::size_t d = 0; d < dimensions; ++d) {
        EXPECT_NE(repeated[d], first[d]);
        EXPECT_NE(others.at(0)[d], first[d]);
        for (std::size_t e = 0; e < d; ++e) {
            EXPECT_NE(first[e], first[d]);
        }
    }
}

} // namespace
} // namespace gonio::sim
