// thin_plate.hpp: a plane-parallel plate as one surface: all internal reflections, no displacement. A pane of glass
// (Radiance's glass), a beam splitter.
#pragma once

#include "material.hpp"
#include "two_way.hpp"

namespace gonio::sim {

// Index of refraction, and the absorption along the normal (absorption per length times thickness, 0 or more).
struct Plate {
    double index;
    double optical_depth;

    // Powers of the plate: the internal reflections add up incoherently, s and p each for itself.
    [[nodiscard]] Two_way powers(double cosine) const;
};

class Thin_plate final : public Material {
public:
    explicit Thin_plate(const Plate &plate) : plate_(plate) {}
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override;
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override;
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override;
    [[nodiscard]] bool polarises() const override { return true; }

private:
    Plate plate_;
};

// A plate known by its powers, the same at all angles and from both sides: a beam splitter at its angle of use.
class Splitter final : public Material {
public:
    // reflectance + transmittance at most 1, for s and for p. Between s and p light that goes through keeps its phase,
    // light that goes back has that of Mirror.
    Splitter(double reflectance_s, double reflectance_p, double transmittance_s, double transmittance_p);
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override;
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override;
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override;
    [[nodiscard]] bool polarises() const override { return true; }

private:
    Two_way powers_;
};

// What Radiance's glass describes by its transmissivity: the part of light that remains after one passage along the
// normal, surfaces left out. At cos theta_2 inside, transmissivity^(1 / cos theta_2) remains.
Plate glass_plate(double transmissivity, double index = 1.52);

} // namespace gonio::sim
