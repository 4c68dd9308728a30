// material.hpp: what a surface does to light: the interface, one file per material beside it.
#pragma once

#include "random.hpp"
#include "vector.hpp"

namespace gonio::sim {

// State of polarisation, each part relative to the intensity: q = (I_s - I_p) / I, u, v as usual. The reference plane
// is that of incidence: s is along normal x direction. Unpolarised: all zero.
struct Stokes {
    double q = 0.0;
    double u = 0.0;
    double v = 0.0;
};

// Light at a surface, in its local frame: z is the normal on the side that the light comes from, x follows the
// surface's tangent (brushed or rolled finishes have a direction).
struct Arrival {
    Vector towards;  // unit, away from the surface, towards where the light came from: z > 0
    bool from_front; // which side of the surface that is
    Stokes stokes;   // unpolarised if the run is
};

// Light that leaves, in the same local frame.
struct Departure {
    Vector direction; // unit, away from the surface: z > 0 back to the same side, z < 0 through
    double share; // factor on the photon's weight; its mean is the surface's reflectance + transmittance; 0: absorbed
    Stokes stokes;
};

// Directional-hemispherical sums of a surface: scattered and ideal parts together.
struct Albedo {
    double reflectance;
    double transmittance;
};

class Material {
public:
    virtual ~Material() = default;
    // Draws one direction. Uses as few random numbers as it can; share stays below 4.
    [[nodiscard]] virtual Departure scatter(const Arrival &arrival, Photon_random &random) const = 0;
    // DSF [1/sr] = BSDF |cos| of the surface towards `departing` (local frame), ideal mirror and straight-through parts
    // left out. Unpolarised light.
    [[nodiscard]] virtual double dsf_per_sr(const Arrival &arrival, const Vector &departing) const = 0;
    // Of unpolarised light; exact or to 1e-6. Tests hold scatter() against it.
    [[nodiscard]] virtual Albedo albedo(const Arrival &arrival) const = 0;
    // Whether scatter() looks at arrival.stokes.
    [[nodiscard]] virtual bool polarises() const { return false; }
    // Absorption of the medium behind the front, where the material is the boundary of one (dielectric,
    // ggx-dielectric): for Surface::back_absorption_per_mm.
    [[nodiscard]] virtual double inside_absorption_per_mm() const { return 0.0; }
};

} // namespace gonio::sim
