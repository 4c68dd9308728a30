// slices.cpp: whether the arrays of a resolved model agree with each other.
#include "slices.hpp"

#include <stdexcept>

namespace gonio::model {
namespace {

void require(bool holds, const char *what) {
    if (!holds) {
        throw std::invalid_argument(what);
    }
}

// start has one more than `rows`, begins at 0, never falls and ends at `items`.
void check_start(std::span<const std::int64_t> start, std::size_t rows, std::size_t items) {
    bool holds = start.size() == rows + 1 && start.front() == 0 && start.back() == static_cast<std::int64_t>(items);
    for (std::size_t i = 1; holds && i < start.size(); ++i) {
        holds = start[i] >= start[i - 1];
    }
    require(holds, "first items of the slices or lobes do not fit");
}

void check_grids(std::span<const std::int64_t> used, const Grids &grids) {
    for (const std::int64_t one : used) {
        require(one >= 0 && static_cast<std::size_t>(one) < grids.size.size(), "there is no such grid");
    }
}

} // namespace

void check(const Slices &slices, const Grids &grids) {
    require(grids.start.size() == grids.size.size(), "one start per grid is needed");
    const auto all = static_cast<std::int64_t>(grids.values.size());
    constexpr std::int64_t WIDEST = 1 << 20; // its square cannot overflow
    for (std::size_t g = 0; g < grids.size.size(); ++g) {
        const std::int64_t size = grids.size[g];
        require(size >= 2 && size <= WIDEST && grids.start[g] >= 0 && grids.start[g] <= all - size * size,
                "a grid does not lie within the values");
    }
    const std::size_t lobes = slices.lobe_peak.size();
    const std::size_t patches = slices.patch_weight.size();
    const std::size_t fields = slices.field_weight.size();
    require(slices.lobe_frame.size() == 3 * lobes && slices.lobe_whitening.size() == 4 * lobes,
            "one frame, whitening and peak per lobe are needed");
    require(slices.patch_grid.size() == patches, "one grid and weight per patch are needed");
    require(slices.field_grid.size() == fields && slices.field_matrix.size() == 4 * fields &&
                slices.field_shift.size() == 2 * fields && slices.field_as_bsdf.size() == fields,
            "one grid, weight, matrix, shift and kind per background are needed");
    check_start(slices.lobe_start, slices.scale.size(), lobes);
    check_start(slices.patch_start, lobes, patches);
    check_start(slices.field_start, slices.scale.size(), fields);
    check_grids(slices.patch_grid, grids);
    check_grids(slices.field_grid, grids);
}

} // namespace gonio::model
