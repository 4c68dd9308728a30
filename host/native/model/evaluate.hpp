// evaluate.hpp: DSF of a resolved model at millions of outgoing directions.
#pragma once

#include "slices.hpp"

namespace gonio::model {

// DSF [1/sr] towards unit vectors with z >= 0, in slice which[i], or all in the first where `which` is empty; NaN
// towards what is not a unit vector. Throws std::invalid_argument where arrays do not agree.
void evaluate(const Slices &slices, const Grids &grids, std::span<const Vec> unit, std::span<const std::int64_t> which,
              std::span<double> dsf);

} // namespace gonio::model
