// dielectric.hpp: the smooth boundary of a clear medium: Radiance's dielectric and interface. Fresnel for s and p,
// total reflection with its phase. Nothing is lost at the boundary; the medium's absorption is the surface's business.
#pragma once

#include "material.hpp"

namespace gonio::sim {

class Dielectric final : public Material {
public:
    // Indices behind the front and before it.
    explicit Dielectric(double inside_index, double outside_index = 1.0, double inside_absorption_per_mm = 0.0);
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override;
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override;
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override;
    [[nodiscard]] bool polarises() const override { return true; }
    [[nodiscard]] double inside_absorption_per_mm() const override { return inside_absorption_per_mm_; }

private:
    double ratio_from_front_;
    double ratio_from_back_;
    double inside_absorption_per_mm_;
};

} // namespace gonio::sim
