// source.hpp: where photons start.
#pragma once

#include "material.hpp"
#include "scene.hpp"

namespace gonio::sim {

struct Start {
    Vector position;  // lab frame, mm, on the aperture stop
    Vector direction; // unit, lab frame: about -Z
    Stokes stokes;    // relative to s along the lab's `reference`
    Vector reference; // unit, across `direction`: the s axis of `stokes`
};

// Every photon carries the same power; a profile is drawn, not weighted. Random numbers, in this order: two for the
// place on the stop, two for the direction, more only for stray light.
class Source {
public:
    virtual ~Source() = default;
    [[nodiscard]] virtual Start start(Photon_random &random) const = 0;
};

} // namespace gonio::sim
