// place.hpp: a place on the receiver sphere in 64 bits, and which cap of the sphere holds it. The sphere is seen as a
// cube: a face and two coordinates of 30 bits, 1.3e-9 rad at worst, alike everywhere: no poles, no azimuth that wraps.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "vector.hpp"

namespace gonio::sim {

inline constexpr unsigned cube_faces = 6;
inline constexpr unsigned place_bits = 30; // per coordinate

// Each word: a coordinate in its upper 30 bits. Lower bits of `u`: the face's axis; lowest of `v`: its negative side.
struct Place {
    std::uint32_t u;
    std::uint32_t v;
};

// A hit as it is kept: 12 bytes.
struct Stored_hit {
    Place place;
    std::uint32_t weight;
};

inline unsigned face_of(const Place &place) {
    return 2U * (place.u & 3U) + (place.v & 1U);
}

// On the face's plane, in (-1, 1), the middle of its step. No rounding anywhere.
inline double face_coordinate(std::uint32_t word) {
    return (static_cast<double>(static_cast<std::int32_t>(word >> 2U)) + 0.5) * 0x1p-29 - 1.0;
}

// `direction`: not zero, any length.
inline Place place_of(const Vector &direction) {
    std::array<double, 5> const p = {direction.x, direction.y, direction.z, direction.x, direction.y};
    double const x = std::abs(p[0]);
    double const y = std::abs(p[1]);
    double const z = std::abs(p[2]);
    unsigned const axis = x >= y && x >= z ? 0U : (y >= z ? 1U : 2U);
    double const scale = 0x1p29 / std::abs(p[axis]);
    auto const steps = [](double coordinate) {
        return std::min(static_cast<std::uint32_t>(coordinate + 0x1p29), (1U << place_bits) - 1U) << 2U;
    };
    return {steps(p[axis + 1] * scale) | axis, steps(p[axis + 2] * scale) | (p[axis] < 0.0 ? 1U : 0U)};
}

// What the tests below need of a cap's half angle; pi and more: the whole sphere.
struct Half_angle {
    explicit Half_angle(double rad);
    double cosine;
    double sine;
    double cosine2; // its square, with the cosine's sign
};

// A cap's parts along a face's axes.
struct Face_cap {
    double outward;
    double u;
    double v;
    Half_angle angle;
};

inline double squared_length(double u, double v) {
    return 1.0 + u * u + v * v;
}
inline double along(const Face_cap &cap, double u, double v) {
    return cap.outward + cap.u * u + cap.v * v;
}

// The rule: a place belongs to an aperture if the cosine of the angle between them is at least that of the half angle;
// both sides squared, with their signs. Everybody uses this very expression, so that an aperture's sums are the same
// bits however they are found.
inline bool holds(const Face_cap &cap, double u, double v) {
    double const part = along(cap, u, v);
    return part * std::abs(part) >= cap.angle.cosine2 * squared_length(u, v);
}

// `direction`: unit.
inline Face_cap on_face(const Vector &direction, const Half_angle &angle, unsigned face) {
    std::array<double, 5> const d = {direction.x, direction.y, direction.z, direction.x, direction.y};
    unsigned const axis = face / 2;
    return {(face & 1U) != 0 ? -d[axis] : d[axis], d[axis + 1], d[axis + 2], angle};
}

enum class Overlap { none, part, all };

// How much of a square of the face, `half_width` about its centre, the cap holds. `part` when in doubt.
// The square lies within an angle a of its centre, sin a = sqrt(2) half_width / length of the centre; the cap's edge is
// at cos(h -+ a) from it.
inline Overlap overlap(const Face_cap &cap, double u, double v, double half_width) {
    constexpr double rounding = 1e-13; // of all that follows, many times over
    double const length2 = squared_length(u, v);
    // Never wider than a whole face: sin^2 a = 2/3.
    double const radius2 = std::min(2.0 * half_width * half_width, 2.0 / 3.0 * length2);
    double const centre = along(cap, u, v);
    double const across = cap.angle.cosine * std::sqrt(length2 - radius2);
    double const sine2 = cap.angle.sine * cap.angle.sine;
    double const rise = std::sqrt(sine2 * radius2);
    bool const wider = sine2 * length2 > radius2; // than the square, the cap or, beyond 90 degrees, its complement
    if ((wider || cap.angle.cosine > 0.0) && centre < across - rise - rounding) {
        return Overlap::none;
    }
    return (wider || cap.angle.cosine < 0.0) && centre > across + rise + rounding ? Overlap::all : Overlap::part;
}

struct Range {
    double low;
    double high;
};

// Where the cap may reach on the face, along one of its axes (`across`: the cap's part along it): between the tangent
// planes through the other axis.
inline Range shadow(const Face_cap &cap, double across) {
    double const clear = cap.outward * cap.outward - cap.angle.sine * cap.angle.sine;
    if (cap.outward <= 0.0 || cap.angle.cosine <= 0.0 || clear < 1e-6) {
        return {-1.0, 1.0};
    }
    double const root = cap.angle.sine * std::sqrt(std::max(across * across + clear, 0.0));
    double const middle = across * cap.outward;
    return {(middle - root) / clear - 1e-9, (middle + root) / clear + 1e-9};
}

} // namespace gonio::sim
