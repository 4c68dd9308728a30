// triangulation.hpp: Delaunay triangles of directions: the convex hull of points on the sphere, built point by point.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "hilbert.hpp"
#include "predicates.hpp"

namespace gonio::sphere {

// Points nearer than this are one: nearer than any encoder tells apart, and far enough that rounding to the grid hides
// no point behind others (a cap of this radius is 8e-12 deep; rounding moves points by 8e-13).
constexpr double MERGE_RAD = 4e-6;

class Triangulation {
public:
    using Corners = std::array<Index, 3>;

    // Begins with four points that are not in one plane. Empty where there are none: `points` lie on one circle.
    static std::optional<Triangulation> of(std::vector<Vec> points);

    // One more point. Gives the number of the point that stands for it.
    Index add(const Vec &point);

    [[nodiscard]] const std::vector<Vec> &points() const { return points_; }
    // Counter-clockwise seen from outside.
    [[nodiscard]] const std::vector<Corners> &triangles() const { return triangles_; }
    // Which triangle lies across the edge opposite each corner.
    [[nodiscard]] const std::vector<Corners> &across() const { return across_; }
    // For each point itself, or the nearer one that it was merged with.
    [[nodiscard]] const std::vector<Index> &stands_for() const { return stands_for_; }

private:
    explicit Triangulation(std::vector<Vec> points) : points_(std::move(points)) {}

    bool begin();
    void insert(Index point);
    [[nodiscard]] Index locate(const Vec &p) const;
    bool dig(Index first, const Vec &p);
    void fill(Index point);
    [[nodiscard]] Index nearest_corner(Index triangle, const Vec &p) const;

    struct Border {
        Index from;
        Index to;
        Index outside;
        int edge; // of the triangle outside
    };
    struct Look {
        Index triangle;
        int edge;
    };

    std::vector<Vec> points_;
    std::vector<Index> stands_for_;
    std::vector<Corners> triangles_;
    std::vector<Corners> across_;
    std::vector<char> dug_;
    Vec inside_; // of the hull, strictly
    std::array<Index, 4> first_{};
    Index last_ = 0;
    std::vector<Index> pit_;
    std::vector<Border> border_;
    std::vector<Look> looks_;
};

// Points rounded to the grid, along a Hilbert curve; `order` gets the caller's number of each.
std::vector<Vec> ordered_on_grid(std::span<const Vec> unit, std::vector<Index> &order);

} // namespace gonio::sphere
