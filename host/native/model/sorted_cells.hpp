// sorted_cells.hpp: points of the hemisphere sorted into the cells of a square grid over Lambert's equal-area disc,
// with what each cell holds in all; of crowded, calm cells some points stand for all.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "vec.hpp"

namespace gonio::model {

using sphere::Vec;

struct Measured {
    std::span<const Vec> unit;
    std::span<const double> value;
    std::span<const double> variance;
    std::span<const double> weight; // above zero
};

struct Sorted_cells {
    std::vector<std::int64_t> home;         // of the occupied cells: row * size + column
    std::vector<std::int64_t> start;        // one more than cells: range of the sorted points
    std::vector<std::int64_t> row;          // of the points that stay: sorted by cell, as they came within one
    std::vector<double> weight;             // of these: in each cell their sum is that of all
    std::vector<std::array<double, 6>> sum; // per cell, of these: w, w v, w^2 variance, w times the unit vector
};

// The grid has size x size cells over [-1, 1]^2. All points stay, but of a cell with more than `most` every n-th, where
// the values differ by less than 0.8 of their mean (root mean square), noise apart. Throws std::invalid_argument for a
// size beyond 4096 and columns of unlike length.
Sorted_cells sorted_cells(const Measured &points, std::size_t size, std::size_t most);

} // namespace gonio::model
