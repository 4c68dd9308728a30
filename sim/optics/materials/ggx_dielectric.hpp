// ggx_dielectric.hpp: the rough boundary of a clear medium: Walter et al. (2007), "Microfacet models for refraction
// through rough surfaces", with the GGX distribution, drawn by visible normals (Heitz 2018).
#pragma once

#include "material.hpp"

namespace gonio::sim {

// Light that meets a second facet is lost, as in all models of single scattering. Of 1 at n = 1.5 along the normal:
// alpha 0.1 loses 0.1 % on the way in and 1.1 % on the way out, 0.3: 1.2 % and 10 %, 0.5: 3 % and 25 %; more at grazing
// incidence. Where that counts, trace a rough surface of real geometry with Dielectric. Unpolarised.
class Ggx_dielectric final : public Material {
public:
    // alpha > 0 along the local x and y; the indices must differ.
    Ggx_dielectric(double alpha_x, double alpha_y, double inside_index, double outside_index = 1.0,
                   double inside_absorption_per_mm = 0.0);
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override;
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override;
    // By quadrature, to 1e-5.
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override;
    [[nodiscard]] double inside_absorption_per_mm() const override { return inside_absorption_per_mm_; }

private:
    [[nodiscard]] Vector visible_normal(const Vector &towards, double u, double v) const;
    // Smith's G1 of either hemisphere.
    [[nodiscard]] double unshaded(const Vector &direction) const;
    double alpha_x_;
    double alpha_y_;
    double ratio_from_front_;
    double ratio_from_back_;
    double inside_absorption_per_mm_;
};

} // namespace gonio::sim
