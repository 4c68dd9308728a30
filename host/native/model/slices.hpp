// slices.hpp: a component's model resolved for incident directions, as flat arrays that someone else owns. What they
// mean stands in host/gonio/model/slices.py.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "vec.hpp"

namespace gonio::model {

using sphere::Vec;

struct Grids {
    std::span<const float> values;
    std::span<const std::int64_t> start;
    std::span<const std::int64_t> size;
};

struct Slices {
    std::span<const double> scale;
    std::span<const std::int64_t> lobe_start;
    std::span<const std::int64_t> field_start;
    std::span<const Vec> lobe_frame;        // three per lobe: e1, e2, centre
    std::span<const double> lobe_whitening; // four per lobe, row by row
    std::span<const double> lobe_peak;
    std::span<const std::int64_t> patch_start;
    std::span<const std::int64_t> patch_grid;
    std::span<const double> patch_weight;
    std::span<const std::int64_t> field_grid;
    std::span<const double> field_weight;
    std::span<const double> field_matrix; // four per field, row by row
    std::span<const double> field_shift;  // two per field
    std::span<const bool> field_as_bsdf;
};

// Throws std::invalid_argument where sizes or indices do not agree: what is past this test stays within the arrays.
void check(const Slices &slices, const Grids &grids);

} // namespace gonio::model
