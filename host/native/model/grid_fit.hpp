// grid_fit.hpp: a smooth function on a square grid through scattered, noisy points. What is done, and why, stands in
// host/gonio/model/grid_fit.py.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace gonio::model {

using Place = std::array<double, 2>;

struct Scattered {
    std::span<const Place> position;
    std::span<const double> value;
    std::span<const double> variance;
    std::span<const double> weight;
};

// Nodes, row by row along the second coordinate, of a grid of size x size over [-half_width, half_width]^2.
// Throws std::invalid_argument where size is not 2^p + 1 or the columns are not equally long.
std::vector<double> fit_grid(const Scattered &points, double half_width, std::size_t size);

} // namespace gonio::model
