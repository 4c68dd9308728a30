// vector.hpp: points and directions in three dimensions, and orthonormal frames.
#pragma once

#include <cmath>

namespace gonio::sim {

struct Vector {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;

    friend Vector operator+(const Vector &a, const Vector &b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Vector operator-(const Vector &a, const Vector &b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Vector operator-(const Vector &a) { return {-a.x, -a.y, -a.z}; }
    friend Vector operator*(double s, const Vector &a) { return {s * a.x, s * a.y, s * a.z}; }
    friend bool operator==(const Vector &a, const Vector &b) = default;
};

inline double dot(const Vector &a, const Vector &b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vector cross(const Vector &a, const Vector &b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vector &a) {
    return std::sqrt(dot(a, a));
}
// Unit vector; `a` must not be zero.
inline Vector unit(const Vector &a) {
    return (1.0 / length(a)) * a;
}

// Right-handed orthonormal axes.
struct Frame {
    Vector s;
    Vector t;
    Vector n;

    [[nodiscard]] Vector to_local(const Vector &v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
    [[nodiscard]] Vector to_world(const Vector &v) const { return v.x * s + v.y * t + v.z * n; }
};

// A frame about a unit normal (Duff et al. 2017, "Building an orthonormal basis, revisited").
inline Frame frame_about(const Vector &n) {
    double const sign = std::copysign(1.0, n.z);
    double const a = -1.0 / (sign + n.z);
    double const b = n.x * n.y * a;
    return {{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

} // namespace gonio::sim
