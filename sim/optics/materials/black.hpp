// black.hpp: absorbs all light.
#pragma once

#include "material.hpp"

namespace gonio::sim {

class Black final : public Material {
public:
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random & /*random*/) const override {
        return {arrival.towards, 0.0, {}};
    }
    [[nodiscard]] double dsf_per_sr(const Arrival & /*arrival*/, const Vector & /*departing*/) const override {
        return 0.0;
    }
    [[nodiscard]] Albedo albedo(const Arrival & /*arrival*/) const override { return {0.0, 0.0}; }
};

} // namespace gonio::sim
