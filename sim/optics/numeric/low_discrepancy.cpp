// low_discrepancy.cpp: Sobol's generator matrices as tables of four index bits, and the scramble of eight dimensions at
// once.
#include "low_discrepancy.hpp"

#include <bit>

namespace gonio::sim {
namespace {

using Point = Low_discrepancy::Point;
constexpr std::size_t dimensions = Low_discrepancy::dimensions;
constexpr std::size_t places = 32;

// A primitive polynomial over GF(2), without its first and last coefficient, and the numbers that start the recurrence.
struct Generator {
    std::size_t degree;
    std::uint32_t inner;
    std::array<std::uint32_t, 5> start;
};

// Of dimensions 2 to 8; the first is the radical inverse. Joe and Kuo 2008, "Constructing Sobol sequences with better
// two-dimensional projections", their search criterion D(6).
constexpr std::array<Generator, dimensions - 1> generators = {{{1, 0, {1}},
                                                               {2, 1, {1, 3}},
                                                               {3, 1, {1, 3, 1}},
                                                               {3, 2, {1, 1, 1}},
                                                               {4, 1, {1, 1, 3, 3}},
                                                               {4, 4, {1, 3, 5, 13}},
                                                               {5, 2, {1, 1, 5, 5, 17}}}};

// Column c of a dimension's matrix: what bit c of the index contributes, the first binary place in the lowest bit: the
// scramble works in that order.
constexpr std::array<std::uint32_t, places> columns(std::size_t dimension) {
    std::array<std::uint32_t, places> first_highest{};
    for (std::size_t c = 0; c < places; ++c) {
        if (dimension == 0) {
            first_highest[c] = 1U << (31U - c);
            continue;
        }
        Generator const &g = generators[dimension - 1];
        if (c < g.degree) {
            first_highest[c] = g.start[c] << (31U - c);
            continue;
        }
        std::uint32_t v = first_highest[c - g.degree] ^ (first_highest[c - g.degree] >> g.degree);
        for (std::size_t k = 1; k < g.degree; ++k) {
            v ^= ((g.inner >> (g.degree - 1 - k)) & 1U) * first_highest[c - k];
        }
        first_highest[c] = v;
    }
    std::array<std::uint32_t, places> first_lowest{};
    for (std::size_t c = 0; c < places; ++c) {
        for (std::size_t place = 0; place < places; ++place) {
            first_lowest[c] |= ((first_highest[c] >> place) & 1U) << (31U - place);
        }
    }
    return first_lowest;
}

// For each four bits of the index, what each of their 16 values contributes to all dimensions.
using Table = std::array<std::array<Point, 16>, places / 4>;
constexpr Table make_table() {
    Table table{};
    for (std::size_t dimension = 0; dimension < dimensions; ++dimension) {
        auto const column = columns(dimension);
        for (std::size_t group = 0; group < table.size(); ++group) {
            for (std::uint32_t value = 0; value < 16; ++value) {
                for (std::size_t bit = 0; bit < 4; ++bit) {
                    table[group][value][dimension] ^= ((value >> bit) & 1U) * column[4 * group + bit];
                }
            }
        }
    }
    return table;
}
constexpr Table table = make_table();

} // namespace

Low_discrepancy::Low_discrepancy(std::uint64_t seed) : seed_(seed) {
    choose_scramble(0);
}

void Low_discrepancy::choose_scramble(std::uint32_t repetition) {
    repetition_ = repetition;
    std::array<std::uint32_t, 2> const key = {static_cast<std::uint32_t>(seed_),
                                              static_cast<std::uint32_t>(seed_ >> 32U)};
    for (std::uint32_t i = 0; i < scramble_.size(); ++i) {
        for (std::uint32_t half = 0; half < 2; ++half) {
            // The last word sets these apart from the numbers of photons.
            Philox_block const block = philox4x32({repetition, i, half, 1}, key);
            for (std::size_t lane = 0; lane < block.size(); ++lane) {
                scramble_[i][half * block.size() + lane] = block[lane];
            }
        }
    }
}

Low_discrepancy::Point Low_discrepancy::at(std::uint64_t photon) {
    auto const repetition = static_cast<std::uint32_t>(photon >> 32U);
    if (repetition != repetition_) {
        choose_scramble(repetition);
    }
    Point point{};
    auto index = static_cast<std::uint32_t>(photon);
    for (std::size_t group = 0; index != 0; ++group, index >>= 4U) {
        Point const &part = table[group][index & 15U];
        for (std::size_t d = 0; d < dimensions; ++d) {
            point[d] ^= part[d];
        }
    }
    // Each step is one-to-one and lets a bit change only itself and higher ones.
    for (std::size_t d = 0; d < dimensions; ++d) {
        std::uint32_t x = point[d];
        x ^= x * 0x9E3779BAU;
        x += scramble_[0][d];
        x *= scramble_[1][d] | 1U;
        x ^= x * 0xB7E15162U;
        x += scramble_[2][d];
        x ^= x * 0xC90FDAA2U;
        // The first binary place back to the highest bit.
        x = ((x >> 1U) & 0x55555555U) | ((x & 0x55555555U) << 1U);
        x = ((x >> 2U) & 0x33333333U) | ((x & 0x33333333U) << 2U);
        x = ((x >> 4U) & 0x0F0F0F0FU) | ((x & 0x0F0F0F0FU) << 4U);
        x = ((x >> 8U) & 0x00FF00FFU) | ((x & 0x00FF00FFU) << 8U);
        point[d] = (x >> 16U) | (x << 16U);
    }
    return point;
}

} // namespace gonio::sim
