// near_lobes.hpp: which points lie within lobes, and where in the lobes' own coordinates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vec.hpp"

namespace gonio::model {

using sphere::Vec;

struct Near {
    std::vector<std::int64_t> start; // one more than lobes: of whose rows and places
    std::vector<std::int64_t> row;   // of the points, rising
    std::vector<double> place;       // two per row: v = W u, u [rad] azimuthal equidistant about the centre
};

// Points within `reach` standard deviations along each lobe's longer axis. frame: three vectors per lobe (e1, e2,
// centre); whitening: four numbers, W row by row.
Near near_lobes(std::span<const Vec> unit, std::span<const Vec> frame, std::span<const double> whitening, double reach);

} // namespace gonio::model
