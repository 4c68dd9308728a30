// lambertian.hpp: the same radiance in all directions of a hemisphere, back and through.
#pragma once

#include "material.hpp"

namespace gonio::sim {

class Lambertian final : public Material {
public:
    // Each >= 0, their sum at most 1.
    explicit Lambertian(double reflectance, double transmittance = 0.0);
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override;
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override;
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override;

private:
    double reflectance_;
    double transmittance_;
    double total_;
    double reflected_part_; // of the total
};

} // namespace gonio::sim
