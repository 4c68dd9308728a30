// test_random.cpp: Philox against its authors' known answers, and the order in which a photon gets its numbers.
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "random.hpp"

namespace gonio::sim {
namespace {

// Known-answer vectors of philox4x32-10, published with Random123 (Salmon et al. 2011).
TEST(Philox, known_answers) {
    EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (Philox_block{0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8}));
    EXPECT_EQ(philox4x32({0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF}, {0xFFFFFFFF, 0xFFFFFFFF}),
              (Philox_block{0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD}));
    EXPECT_EQ(philox4x32({0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344}, {0xA4093822, 0x299F31D0}),
              (Philox_block{0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1}));
}

TEST(Photon_random, a_photon_has_its_own_numbers) {
    // Photons that differ in the high or the low half of their number, or in the seed's.
    std::set<double> first;
    for (std::uint64_t const photon : {0ULL, 1ULL, 1ULL << 32U, 1ULL << 63U}) {
        for (std::uint64_t const seed : {0ULL, 1ULL, 1ULL << 32U}) {
            Photon_random random(seed, photon);
            first.insert(random.uniform());
            Photon_random again(seed, photon);
            EXPECT_EQ(first.count(again.uniform()), 1U);
        }
    }
    EXPECT_EQ(first.size(), 12U);
}

TEST(Photon_random, given_numbers_come_first_and_take_none_of_its_own) {
    Photon_random plain(5, 7);
    Photon_random given(5, 7);
    given.give({0, 0x80000000U, 0xFFFFFFFFU}, 3);
    EXPECT_EQ(given.uniform(), 0x1p-33);
    EXPECT_EQ(given.uniform(), 0.5 + 0x1p-33);
    EXPECT_EQ(given.uniform(), 1.0 - 0x1p-33);
    for (int i = 0; i < 10; ++i) {
        EXPECT_EQ(given.uniform(), plain.uniform());
    }
}

// Mean and variance of 10^6 uniform numbers, to four standard errors.
TEST(Photon_random, uniform) {
    constexpr int photons = 100000;
    constexpr int numbers = 10;
    double sum = 0.0;
    double squares = 0.0;
    for (int photon = 0; photon < photons; ++photon) {
        Photon_random random(3, static_cast<std::uint64_t>(photon));
        for (int i = 0; i < numbers; ++i) {
            double const u = random.uniform() - 0.5;
            sum += u;
            squares += u * u;
        }
    }
    constexpr double count = 1.0 * photons * numbers;
    EXPECT_NEAR(sum / count, 0.0, 4.0 * std::sqrt(1.0 / 12.0 / count));
    EXPECT_NEAR(squares / count, 1.0 / 12.0, 4.0 * std::sqrt(1.0 / 180.0 / count));
}

} // namespace
} // namespace gonio::sim
