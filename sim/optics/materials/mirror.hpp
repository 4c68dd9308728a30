// mirror.hpp: an ideal mirror, the same at all angles.
#pragma once

#include "material.hpp"
#include "two_way.hpp"

namespace gonio::sim {

class Mirror final : public Material {
public:
    // In [0, 1], for s and p. Between s and p the mirror keeps the phase of a good conductor: r_s r_p* is negative.
    Mirror(double reflectance_s, double reflectance_p);
    explicit Mirror(double reflectance) : Mirror(reflectance, reflectance) {}
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override;
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override;
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override;
    [[nodiscard]] bool polarises() const override { return true; }

private:
    Two_way powers_;
};

} // namespace gonio::sim
