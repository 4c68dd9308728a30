// voronoi.cpp: sums over triangles; each gives its corners what lies nearer to them than to the other two.
#include "voronoi.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "linear.hpp"

namespace gonio::sphere {
namespace {

// Triangles whose circumcentre is far out, or badly known: more than so many of its shortest side away.
constexpr double LARGE_COSINE = 0.9;
constexpr double LARGE_SIDES = 100.0;

bool is_large(const Vec &a, const Vec &b, const Vec &c, double cos_radius) {
    const double side = std::min({length(b - a), length(c - b), length(a - c)});
    return cos_radius < LARGE_COSINE || 2.0 * (1.0 - cos_radius) > LARGE_SIDES * LARGE_SIDES * side * side;
}

Vec circumcentre_of(const Triangulation &hull, Index triangle) {
    const Triangulation::Corners &t = hull.triangles()[triangle];
    double size = 0.0;
    return circumcentre(hull.points()[t[0]], hull.points()[t[1]], hull.points()[t[2]], size);
}

// Signed area of the spherical triangle of unit vectors (A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30,
// 125, 1983), from differences, which keep the digits of small ones. b and c lie on a's half of the sphere.
double near_area(const Vec &a, const Vec &b, const Vec &c) {
    return 2.0 * std::atan2(dot(a, cross(b - a, c - a)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
}

// Area between point a and the arc from one circumcentre to the other, and that arc's part of the first moment. The sum
// over all cells is 4 pi wherever the circumcentres are: those of triangles that look at the far side of the sphere may
// be anywhere.
Part large_part(const Vec &a, const Vec &begin, const Vec &end) {
    const Vec normal = cross(begin, end);
    const double sine = length(normal);
    const double arc = std::atan2(sine, dot(begin, end));
    Part part{0.0, sine > 0.0 ? (0.5 * arc / sine) * normal : Vec{}};
    if (dot(a, begin) < 0.0 && dot(a, end) < 0.0) {
        // The triangle and its opposite at -a are a lune.
        const Vec back = -1.0 * a;
        const Vec u = begin - back;
        const Vec v = end - back;
        const double angle = std::atan2(dot(a, cross(u, v)), dot(u, v) - dot(a, u) * dot(a, v));
        part.area = 2.0 * angle + near_area(back, begin, end);
    } else {
        part.area = near_area(a, begin, end);
    }
    return part;
}

// All cells without reach, and the least cosine of a circumradius about each point.
void whole_cells(const Triangulation &hull, Cells &cells, std::vector<double> &farthest, Linear_less_voronoi &linear) {
    const std::vector<Vec> &points = hull.points();
    const std::size_t count = hull.triangles().size();
    std::vector<char> large(count, 0);
    for (std::size_t number = 0; number < count; ++number) {
        const Triangulation::Corners &t = hull.triangles()[number];
        const double cos_radius = dot(circumcentre_of(hull, static_cast<Index>(number)), points[t[0]]);
        large[number] = is_large(points[t[0]], points[t[1]], points[t[2]], cos_radius) ? 1 : 0;
        for (const Index corner : t) {
            farthest[corner] = std::min(farthest[corner], cos_radius);
        }
    }
    for (std::size_t number = 0; number < count; ++number) {
        const Triangulation::Corners &t = hull.triangles()[number];
        double size = 0.0;
        const Vec centre = circumcentre(points[t[0]], points[t[1]], points[t[2]], size);
        std::array<double, 3> excess{};
        for (int e = 0; e < 3; ++e) {
            const Index from = t[(e + 1) % 3];
            const Index to = t[(e + 2) % 3];
            const Index next = hull.across()[number][e];
            const Bisector bisector(points[from], points[to]);
            const double tangent = bisector.tan_half_arc(centre);
            excess[e] = triangle_excess(bisector.tan_half, tangent);
            if (large[number] != 0 || large[next] != 0) {
                const Part part = large_part(points[from], circumcentre_of(hull, next), centre);
                cells.solid[from] += part.area;
                cells.moment[from] += part.moment;
            } else {
                // Half of the first moment's arc, and half of the area, is the other triangle's.
                const Vec push = (atan_of(tangent) / bisector.chord) * (points[to] - points[from]);
                cells.solid[from] += excess[e];
                cells.solid[to] += excess[e];
                cells.moment[from] -= push;
                cells.moment[to] += push;
            }
        }
        const std::array<double, 3> share = {excess[1] + excess[2], excess[2] + excess[0], excess[0] + excess[1]};
        linear.add(static_cast<Index>(number), share, dot(centre, points[t[0]]), size);
    }
}

} // namespace

Vec circumcentre(const Vec &a, const Vec &b, const Vec &c, double &size) {
    const Vec u = b - a;
    const Vec v = c - b;
    const Vec w = a - c;
    const double uu = dot(u, u);
    const double vv = dot(v, v);
    const double ww = dot(w, w);
    // From the two shorter sides: the error is theirs.
    const Vec normal = uu > vv && uu > ww ? cross(v, w) : vv > ww ? cross(w, u) : cross(u, v);
    size = length(normal);
    return (1.0 / size) * normal;
}

Cells cells_of(const Triangulation &hull, std::span<const double> reach, Index real) {
    const std::vector<Vec> &points = hull.points();
    const std::size_t n = points.size();
    Cells cells{std::vector<double>(n, 0.0), {}, std::vector<Vec>(n)};
    std::vector<double> farthest(n, 1.0);
    std::vector<double> cos_reach(n);
    for (std::size_t i = 0; i < n; ++i) {
        cos_reach[i] = reach[i] < PI ? std::cos(reach[i]) : -2.0;
    }
    Linear_less_voronoi linear(hull, cos_reach, real);
    whole_cells(hull, cells, farthest, linear);

    // Cells that reach too far are made again, edge by edge.
    std::vector<char> cut(n);
    for (std::size_t i = 0; i < n; ++i) {
        cut[i] = farthest[i] < cos_reach[i] ? 1 : 0;
        if (cut[i] != 0) {
            cells.solid[i] = 0.0;
            cells.moment[i] = {};
        }
    }
    for (std::size_t number = 0; number < hull.triangles().size(); ++number) {
        const Triangulation::Corners &t = hull.triangles()[number];
        for (int e = 0; e < 3; ++e) {
            const Index from = t[(e + 1) % 3];
            const Index to = t[(e + 2) % 3];
            if (cut[from] == 0 || from >= real) {
                continue;
            }
            const Bisector bisector(points[from], points[to]);
            const double end =
                2.0 * std::atan(bisector.tan_half_arc(circumcentre_of(hull, static_cast<Index>(number))));
            const double begin =
                2.0 * std::atan(bisector.tan_half_arc(circumcentre_of(hull, hull.across()[number][e])));
            const Part part = part_within(points[from], points[to], begin, end, reach[from]);
            cells.solid[from] += part.area;
            cells.moment[from] += part.moment;
        }
    }
    cells.linear = linear.finished();
    for (std::size_t i = 0; i < n; ++i) {
        cells.solid[i] = std::max(cells.solid[i], 0.0); // rounding can leave -1e-17
        cells.linear[i] += cells.solid[i];
    }
    return cells;
}

} // namespace gonio::sphere
