// suitable_size.hpp: how fine a grid scattered points can fill.
#pragma once

#include <cstddef>
#include <span>

#include "grid_fit.hpp"

namespace gonio::model {

// Nodes per side, 2^p + 1, of a grid over [-half_width, half_width]^2: see host/gonio/model/grid_fit.py.
std::size_t suitable_size(std::span<const Place> position, double half_width, std::size_t most_cells);

} // namespace gonio::model
