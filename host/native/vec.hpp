// vec.hpp: vectors of three doubles.
#pragma once

#include <cmath>

namespace gonio::sphere {

struct Vec {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;
};

inline Vec operator+(const Vec &a, const Vec &b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec operator-(const Vec &a, const Vec &b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec operator*(double f, const Vec &a) {
    return {f * a.x, f * a.y, f * a.z};
}
inline Vec &operator+=(Vec &a, const Vec &b) {
    return a = a + b;
}
inline Vec &operator-=(Vec &a, const Vec &b) {
    return a = a - b;
}

inline double dot(const Vec &a, const Vec &b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec cross(const Vec &a, const Vec &b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vec &a) {
    return std::sqrt(dot(a, a));
}
inline Vec normalised(const Vec &a) {
    return (1.0 / length(a)) * a;
}
inline double component(const Vec &a, int axis) {
    return axis == 0 ? a.x : axis == 1 ? a.y : a.z;
}

// Angle between unit vectors from their distance: exact for small ones.
inline double angle_of_chord(double chord) {
    return 2.0 * std::asin(std::fmin(0.5 * chord, 1.0));
}

// Two unit vectors square to the unit vector and to each other.
struct Tangents {
    Vec e1;
    Vec e2;
};
inline Tangents tangents(const Vec &unit) {
    const Vec helper = std::fabs(unit.z) < 0.9 ? Vec{0.0, 0.0, 1.0} : Vec{0.0, 1.0, 0.0};
    const Vec e1 = normalised(cross(helper, unit));
    return {e1, cross(unit, e1)};
}

} // namespace gonio::sphere
