// hilbert.hpp: an order of directions in which neighbours come soon after one another.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vec.hpp"

namespace gonio::sphere {

using Index = std::int32_t;

// Indices of the unit vectors along a Hilbert curve over the faces of a cube.
std::vector<Index> hilbert_order(std::span<const Vec> directions);

} // namespace gonio::sphere
