// pane.hpp: a solid pane of a clear medium with black rims: glazing, and the body of window glass.
#pragma once

#include <array>

#include "elementary.hpp"
#include "sample_parts.hpp"

namespace gonio::sim {

// A random surface: Gaussian correlation exp(-(d / length)^2), Gaussian heights. Smooth if rms_mm is 0.
struct Roughness {
    double rms_mm = 0.0;
    double correlation_mm = 1.0;
    std::uint64_t seed = 0;
};

struct Pane {
    std::array<double, 2> size_mm; // along x and y
    double front_z_mm;
    double thickness_mm;         // in the middle
    Sine_cosine wedge{0.0, 1.0}; // between the faces; thicker towards +y
    Roughness front{};
    Roughness back{};
};

// Faces of a dielectric each (the same medium); the rims absorb: whoever holds the pane.
void add_pane(Sample_parts &parts, const Pane &pane, const Material &front, const Material &back);

} // namespace gonio::sim
