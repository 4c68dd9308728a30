// voronoi.hpp: the cells of a triangulation's points: areas, first moments, and weights of linear interpolation.
#pragma once

#include <span>
#include <vector>

#include "triangulation.hpp"
#include "voronoi_parts.hpp"

namespace gonio::sphere {

struct Cells {
    std::vector<double> solid;
    std::vector<double> linear;
    std::vector<Vec> moment;
};

// Cells of the triangulation's first `real` points; the others only bound them. No cell reaches farther than `reach`
// from its point (one value per point of the triangulation).
Cells cells_of(const Triangulation &triangulation, std::span<const double> reach, Index real);

// Of distinct points on one circle of the sphere: lunes, whose borders meet in the circle's axis.
Cells cells_on_circle(std::span<const Vec> points, std::span<const double> reach);

// Indices of points on one circle in the order about its axis, counter-clockwise; those that repeat another come right
// after it.
std::vector<Index> order_on_circle(std::span<const Vec> points, Vec &axis);

// The unit normal of a triangle, outwards of the hull: its circumcentre on the sphere. `size` gets twice its plane
// area.
Vec circumcentre(const Vec &a, const Vec &b, const Vec &c, double &size);

} // namespace gonio::sphere
