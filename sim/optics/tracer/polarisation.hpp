// polarisation.hpp: the axis to which a photon's Stokes vector refers, from one plane of incidence to the next.
#pragma once

#include "material.hpp"
#include "vector.hpp"

namespace gonio::sim {

// The s axis at a surface, unit, across `direction` of travel. Along the normal there is no plane of incidence: then
// the local frame's t serves, for light that arrives and light that leaves alike. Which way it points does not matter.
inline Vector s_axis(const Frame &local, const Vector &direction) {
    Vector const across = cross(local.n, direction);
    double const square = dot(across, across);
    return square > 1e-12 ? (1.0 / std::sqrt(square)) * across : local.t;
}

// The same light relative to `to`: both axes are unit and across `direction`. With p = direction x s, light with u = 1
// swings halfway between s and p (Born and Wolf, sections 1.4 and 10.8).
inline Stokes turned(const Stokes &light, const Vector &from, const Vector &to, const Vector &direction) {
    double const cosine = dot(from, to);
    double const sine = dot(cross(direction, from), to);
    double const cosine_twice = cosine * cosine - sine * sine;
    double const sine_twice = 2.0 * cosine * sine;
    return {cosine_twice * light.q + sine_twice * light.u, cosine_twice * light.u - sine_twice * light.q, light.v};
}

} // namespace gonio::sim
