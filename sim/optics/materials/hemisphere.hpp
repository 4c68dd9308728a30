// hemisphere.hpp: directions drawn from a hemisphere as a Lambertian surface sends them.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "elementary.hpp"
#include "vector.hpp"

namespace gonio::sim {

// z > 0, density cos / pi per sr; u, v in [0, 1].
inline Vector cosine_direction(double u, double v) {
    double const radius = std::sqrt(u);
    Sine_cosine const azimuth = sine_cosine_of_turns(v);
    return {radius * azimuth.cosine, radius * azimuth.sine, std::sqrt(std::max(1.0 - u, 0x1p-40))};
}

inline double cosine_density_per_sr(const Vector &direction) {
    return std::abs(direction.z) * std::numbers::inv_pi;
}

} // namespace gonio::sim
