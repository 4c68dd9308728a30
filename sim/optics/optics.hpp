// optics.hpp: what a detector reads: the interface that the closed forms and the photon map implement.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace gonio::sim {

using Vec3 = std::array<double, 3>;

// Directions are unit vectors in the sample frame, pointing away from the sample; `incident` towards the source.
struct Reading {
    Vec3 incident;
    Vec3 outgoing;                 // to the centre of the detector's aperture
    bool sample_mounted;           // false: the free beam
    Vec3 lab_up = {0.0, 1.0, 0.0}; // the lab's +Y, sample frame: how a beam that is not round lies on the sample
    bool sample_turning = false;   // the sample's axes move
};

class Optics {
public:
    virtual ~Optics() = default;
    // Irradiance at the detector, averaged over its aperture, times r^2 and divided by the beam's power [1/sr]:
    // the DSF as an instrument with this beam and aperture sees it, before shading by the detector's head.
    // Angles of the free beam (sample_mounted false) are about the straight-through direction.
    [[nodiscard]] virtual double apparent_dsf_per_sr(const Reading &reading) const = 0;
    // Wall time so far in which a reading was waited for: a twin in real time stops its clock for it.
    [[nodiscard]] virtual std::int64_t held_ns() const { return 0; }
    // What the journal of a run should say about its readings, one sentence; empty: nothing.
    [[nodiscard]] virtual std::string account() const { return {}; }
};

} // namespace gonio::sim
