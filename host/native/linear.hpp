// linear.hpp: what linear interpolation on the triangles gives each point beyond its Voronoi share.
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "triangulation.hpp"

namespace gonio::sphere {

// A triangle inside the coverage (its circumcentre is within the reach of its corners, all of them real) gives a third
// of its area to each corner. Triangles whose corners lie on one circle could have been cut otherwise: together they
// are a fan about their middle, which has the mean of all corners' values.
class Linear_less_voronoi {
public:
    Linear_less_voronoi(const Triangulation &hull, std::span<const double> cos_reach, Index real);

    // The next triangle: its corners' Voronoi shares, the cosine of its circumradius, twice its plane area.
    void add(Index triangle, const std::array<double, 3> &share, double cos_radius, double size);

    // The sum per point, after all triangles.
    std::vector<double> finished();

private:
    void fans();
    void fan(std::span<const std::pair<Index, Index>> face);
    [[nodiscard]] double area_of(Index triangle) const;

    const Triangulation &hull_;
    std::span<const double> cos_reach_;
    Index real_;
    std::vector<char> covered_;
    std::vector<double> extra_;
    std::vector<std::pair<Index, Index>> ties_; // triangles on both sides of an edge, on one circle
    std::vector<Index> face_;
};

} // namespace gonio::sphere
