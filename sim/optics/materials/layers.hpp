// layers.hpp: a stack of plates and coatings as one surface: reflections between them added up incoherently, for s and
// p each for itself. A glazing unit without displacement.
#pragma once

#include <variant>
#include <vector>

#include "material.hpp"
#include "thin_plate.hpp"

namespace gonio::sim {

// A layer known by its powers, the same at all angles; the two sides may reflect differently.
struct Coating {
    double front_reflectance_s;
    double front_reflectance_p;
    double back_reflectance_s;
    double back_reflectance_p;
    double transmittance_s; // the same from both sides
    double transmittance_p;
};

class Layers final : public Material {
public:
    using Layer = std::variant<Plate, Coating>;
    // From front to back, at least one. Air between them.
    explicit Layers(std::vector<Layer> layers) : layers_(std::move(layers)) {}
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override;
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override;
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override;
    [[nodiscard]] bool polarises() const override { return true; }

private:
    [[nodiscard]] Two_way powers(const Arrival &arrival) const;
    std::vector<Layer> layers_;
};

} // namespace gonio::sim
