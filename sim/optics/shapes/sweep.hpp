// sweep.hpp: the middle and half of a sweep about an axis, with which arcs tell what belongs to them: the angle to the
// middle direction is at most half the sweep, a comparison of cosines that holds for every sweep up to a full turn.
#pragma once

#include <cmath>

#include "elementary.hpp"
#include "vector.hpp"

namespace gonio::sim {

struct Sweep {
    Vector mid;          // unit, across the axis
    double cosine;       // of half the sweep
    double widest_sine;  // of half the sweep, or of a quarter turn if that is less: reach to either side of mid
    double least_cosine; // cosine, with edge_rad added to half the sweep; below -1 if that makes a full turn
};

inline Sweep sweep_about(const Vector &axis, const Vector &start, double sweep_rad, double edge_rad) {
    constexpr double pi = elementary::pi;
    auto const [sine, cosine] = sine_cosine(0.5 * sweep_rad);
    double const half = std::abs(0.5 * sweep_rad);
    bool const full = half + edge_rad >= pi;
    return {cosine * start + sine * cross(axis, start), full ? -1.0 : cosine, 2.0 * half < pi ? std::abs(sine) : 1.0,
            full ? -2.0 : sine_cosine(half + edge_rad).cosine};
}

} // namespace gonio::sim
