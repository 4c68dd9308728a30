// sorted_cells.hpp: points of the hemisphere sorted into the cells of a square grid over Lambert's equal-area disc.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vec.hpp"

namespace gonio::model {

using sphere::Vec;

struct Sorted_cells {
    std::vector<std::int64_t> order; // of the points: sorted by cell, as they came within one
    std::vector<std::int64_t> home;  // of the occupied cells: row * size + column
    std::vector<std::int64_t> start; // one more than cells: range of the sorted points
};

// The grid has size x size cells over [-1, 1]^2. Throws std::invalid_argument for a size beyond 4096.
Sorted_cells sorted_cells(std::span<const Vec> unit, std::size_t size);

} // namespace gonio::model
