// circle.cpp: cells of points that all lie on one circle of the sphere.
#include <algorithm>
#include <array>
#include <cstddef>

#include "voronoi.hpp"

namespace gonio::sphere {
namespace {

constexpr double ASIDE = 1e-8; // opposite points have no bisector in the plane's sense: one is moved by this

Vec axis_of(std::span<const Vec> points) {
    const auto farthest = [&](auto &&measure) {
        return *std::max_element(points.begin(), points.end(),
                                 [&](const Vec &p, const Vec &q) { return measure(p) < measure(q); });
    };
    const Vec a = points[0];
    const Vec b = farthest([&](const Vec &p) { return length(p - a); });
    const Vec c = farthest([&](const Vec &p) { return length(cross(p - a, b - a)); });
    for (const Vec &normal : {cross(b - a, c - a), cross(a, b)}) {
        if (length(normal) > 1e-14) {
            return normalised(normal);
        }
    }
    return tangents(normalised(a)).e1;
}

} // namespace

std::vector<Index> order_on_circle(std::span<const Vec> points, Vec &axis) {
    std::vector<std::pair<double, Index>> azimuth(points.size());
    axis = axis_of(points);
    const auto [e1, e2] = tangents(axis);
    for (std::size_t i = 0; i < points.size(); ++i) {
        azimuth[i] = {std::atan2(dot(points[i], e2), dot(points[i], e1)), static_cast<Index>(i)};
    }
    std::sort(azimuth.begin(), azimuth.end());
    std::vector<Index> order(points.size());
    std::transform(azimuth.begin(), azimuth.end(), order.begin(), [](const auto &one) { return one.second; });
    return order;
}

Cells cells_on_circle(std::span<const Vec> points, std::span<const double> reach) {
    const std::size_t n = points.size();
    Cells cells{std::vector<double>(n, 0.0), {}, std::vector<Vec>(n)};
    if (n == 1) {
        const double sine = std::sin(reach[0]);
        cells.solid[0] = 2.0 * PI * (1.0 - std::cos(reach[0]));
        cells.moment[0] = PI * sine * sine * points[0];
    } else if (n > 1) {
        Vec axis;
        const std::vector<Index> order = order_on_circle(points, axis);
        for (std::size_t k = 0; k < n; ++k) {
            const Index one = order[k];
            const Index next = order[k + 1 < n ? k + 1 : 0];
            const Vec a = points[one];
            Vec b = points[next];
            if (length(a + b) < ASIDE) {
                b += ASIDE * cross(axis, b);
            }
            // Half of the great circle that bisects them, from one end of the axis to the other.
            const auto arc = [&](const Vec &p, const Vec &q, const Vec &end) {
                return 2.0 * std::atan(Bisector(p, q).tan_half_arc(end));
            };
            const Vec back = -1.0 * axis;
            for (const auto &[point, part] :
                 {std::pair{one, part_within(a, b, arc(a, b, back), arc(a, b, axis), std::min(reach[one], PI))},
                  std::pair{next, part_within(b, a, arc(b, a, axis), arc(b, a, back), std::min(reach[next], PI))}}) {
                cells.solid[point] += part.area;
                cells.moment[point] += part.moment;
            }
        }
    }
    cells.linear = cells.solid;
    return cells;
}

} // namespace gonio::sphere
