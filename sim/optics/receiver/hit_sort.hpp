// hit_sort.hpp: hits put in the order of a grid on each face of the cube, and of quadtrees in its squares, in their own
// memory.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "place.hpp"

namespace gonio::sim {

// A face has 2^level columns (by u) of as many rows (by v). Square number: (face * 2^level + column) * 2^level + row.
struct Hit_grid {
    unsigned level = 0;
    std::vector<std::uint32_t> starts; // first hit of each square, and the end

    [[nodiscard]] std::size_t side() const { return std::size_t{1} << level; }
};

// A square that holds more is halved by u, each half by v, and so on, and its hits are in that order.
inline constexpr std::size_t crowd = 32;

Hit_grid sort_hits(std::span<Stored_hit> hits, unsigned threads);

// On which half of a square, whose side is 2^-level of the face's, a hit lies.
inline bool upper_half(std::uint32_t word, unsigned level) {
    return (word << level & 0x80000000U) != 0;
}

} // namespace gonio::sim
