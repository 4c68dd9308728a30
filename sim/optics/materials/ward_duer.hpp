// ward_duer.hpp: a diffuse part and a Ward lobe with two roughnesses, as the finishes of paper [1]: rolled metal sheet,
// glossy paint. The lobe: ward_lobe.hpp.
#pragma once

#include <optional>

#include "material.hpp"
#include "ward_lobe.hpp"

namespace gonio::sim {

class Ward_duer final : public Material {
public:
    // Total reflectance and the share of it that is specular, both in [0, 1]. Roughness along the local x (the
    // surface's tangent) and y: both > 0, or both 0: an ideal mirror part.
    Ward_duer(double reflectance, double specular_share, double roughness_x, double roughness_y);
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override;
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override;
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override;

private:
    double reflectance_;
    double specular_share_;
    std::optional<Ward_lobe> lobe_; // none: ideal
};

} // namespace gonio::sim
