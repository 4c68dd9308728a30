// parts.hpp: the triangulations of a set of directions: one, or one per hemisphere, with the horizon for a border.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "voronoi.hpp"

namespace gonio::sphere {

// The points of one hemisphere, or all.
struct Part_of_sphere {
    double side = 0.0;         // 1 where z >= 0, -1 where z < 0; 0: the whole sphere
    std::vector<Vec> points;   // the real ones, then mirror images of those near the horizon
    std::vector<Index> number; // the caller's number of each
    Index real = 0;
    std::optional<Triangulation> hull; // none: the points lie on one circle
    std::vector<Index> stands_for;     // per point
};

// Each part is made in a thread of its own and handed to `use` there.
void for_each_part(std::span<const Vec> unit, bool cut_at_horizon, const std::function<void(Part_of_sphere &&)> &use);

// How far the caller's points own directions, and which of them share their reach with their neighbours, so that fine
// tracks meet the coarse ones around them: those give it to neighbours within it, and what one of three reaches of the
// place that is equally far from them all three reach, one after the other.
struct Reach {
    std::span<const double> rad;
    std::span<const bool> shared; // empty: by none
};

// Cells of the caller's points; repeated points share theirs.
Cells cells_of_points(std::span<const Vec> unit, const Reach &reach, bool cut_at_horizon);

// For each point of the part the reach of the one that stands for it: the widest of those it stands for, shared.
std::vector<double> reach_of(const Part_of_sphere &part, const Reach &reach);

// The caller's points' reach, shared.
std::vector<double> shared_reach(std::span<const Vec> unit, const Reach &reach);

// The caller's numbers of points that are neighbours in the triangulation, pair after pair.
std::vector<std::int64_t> edges_of(const Part_of_sphere &part);

} // namespace gonio::sphere
