// turned_over.hpp: a material with its two sides exchanged: a bubble is a ball of glass turned inside out.
#pragma once

#include "material.hpp"

namespace gonio::sim {

class Turned_over final : public Material {
public:
    // Keeps a reference.
    explicit Turned_over(const Material &other) : other_(other) {}

    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override {
        return other_.scatter(turned(arrival), random);
    }
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override {
        return other_.dsf_per_sr(turned(arrival), departing);
    }
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override { return other_.albedo(turned(arrival)); }
    [[nodiscard]] bool polarises() const override { return other_.polarises(); }

private:
    static Arrival turned(Arrival arrival) {
        arrival.from_front = !arrival.from_front;
        return arrival;
    }

    const Material &other_;
};

} // namespace gonio::sim
