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

// Cells of the caller's points; repeated points share theirs.
Cells cells_of_points(std::span<const Vec> unit, std::span<const double> reach, bool cut_at_horizon);

// For each point of the part the widest reach (the caller's) among those that it stands for.
std::vector<double> reach_of(const Part_of_sphere &part, std::span<const double> reach);

// The caller's numbers of points that are neighbours in the triangulation, pair after pair.
std::vector<std::int64_t> edges_of(const Part_of_sphere &part);

} // namespace gonio::sphere
