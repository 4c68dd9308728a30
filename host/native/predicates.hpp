// predicates.hpp: on which side of a plane a point lies, decided exactly.
#pragma once

#include <cstdint>

#include "vec.hpp"

namespace gonio::sphere {

// Coordinates are whole multiples of 2^-40 between -1 and 1. Their differences are exact in double, and the
// determinant of three differences fits 128 bits: 41 bits each, 6 products, below 2^126.
constexpr double GRID = 0x1p40;

inline Vec on_grid(const Vec &v) {
    return {std::nearbyint(v.x * GRID) / GRID, std::nearbyint(v.y * GRID) / GRID, std::nearbyint(v.z * GRID) / GRID};
}

inline int exact_side(const Vec &u, const Vec &v, const Vec &w) {
    const auto whole = [](double x) { return static_cast<std::int64_t>(x * GRID); };
    __extension__ using Wide = __int128;
    const auto minor = [&](double a, double d, double b, double c) {
        return static_cast<Wide>(whole(a)) * whole(d) - static_cast<Wide>(whole(b)) * whole(c);
    };
    const Wide determinant = minor(u.y, v.z, u.z, v.y) * whole(w.x) + minor(u.z, v.x, u.x, v.z) * whole(w.y) +
                             minor(u.x, v.y, u.y, v.x) * whole(w.z);
    return determinant > 0 ? 1 : determinant < 0 ? -1 : 0;
}

// 1 where d is on the side from which a, b, c run counter-clockwise, -1 on the other, 0 in their plane.
inline int side_of(const Vec &a, const Vec &b, const Vec &c, const Vec &d) {
    const Vec u = b - a;
    const Vec v = c - a;
    const Vec w = d - a;
    const double p1 = u.y * v.z;
    const double p2 = u.z * v.y;
    const double p3 = u.z * v.x;
    const double p4 = u.x * v.z;
    const double p5 = u.x * v.y;
    const double p6 = u.y * v.x;
    const double determinant = (p1 - p2) * w.x + (p3 - p4) * w.y + (p5 - p6) * w.z;
    const double permanent = (std::fabs(p1) + std::fabs(p2)) * std::fabs(w.x) +
                             (std::fabs(p3) + std::fabs(p4)) * std::fabs(w.y) +
                             (std::fabs(p5) + std::fabs(p6)) * std::fabs(w.z);
    // Five roundings of half an epsilon each along every path (differences are exact): less than 8 of them.
    const double bound = 4.0 * 0x1p-52 * permanent;
    if (determinant > bound) {
        return 1;
    }
    if (determinant < -bound) {
        return -1;
    }
    return exact_side(u, v, w);
}

} // namespace gonio::sphere
