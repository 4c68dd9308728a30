// shading.hpp: what the detector's head takes from the beam when it stands before the source.
#pragma once

#include "optics.hpp"

namespace gonio::sim {

// Area that two circles of these radii share when their centres are `distance` apart.
double overlap_area(double radius_a, double radius_b, double distance);

struct Head {
    double head_diameter_mm;
    double beam_diameter_mm; // where the head crosses the beam
    double arm_radius_mm;

    // Share of the beam that still reaches the sample; both are directions from the sample, in one frame.
    [[nodiscard]] double transmitted(const Vec3 &incident, const Vec3 &outgoing) const;
};

} // namespace gonio::sim
