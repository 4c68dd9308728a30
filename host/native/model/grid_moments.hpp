// grid_moments.hpp: all that a weighted least-squares fit of a bilinear grid needs of the points in each cell.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace gonio::model {

// Sums over points of something times x^a y^b, (x, y) from 0 to 1 over the cell; number a + N b, a and b below N.
template <std::size_t N> using Moments = std::array<double, N * N>;

struct Cell {
    Moments<3> mass; // of the weight
    Moments<2> load; // of weight times value
};

struct Level {
    std::size_t cells = 0; // along each side
    std::vector<Cell> cell;
    std::vector<Moments<3>> noise; // of weight^2 times variance; none where nothing is noisy
};

// The same points in cells twice as wide.
Level coarser(const Level &fine);

} // namespace gonio::model
