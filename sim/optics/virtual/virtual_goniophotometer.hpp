// virtual_goniophotometer.hpp: one incident direction and one band of a scenario, ready to trace: the interface of the
// twin, of the Python module and of the benchmarks.
#pragma once

#include <memory>
#include <span>

#include "direction_index.hpp"
#include "hit_map.hpp"
#include "make_scene.hpp"
#include "photon_scenario.hpp"

namespace gonio::sim {

class Virtual_goniophotometer {
public:
    // `mounted` false: the free beam.
    Virtual_goniophotometer(const Photon_scenario &scenario, const Band &band, const Incident &incident, bool mounted,
                            Walk walk = Walk::automatic);

    struct Sums {
        Aperture_sums apertures;
        Balance balance;
    };
    // Streams the photons of the range through apertures of the detector's size at these directions (sample frame).
    // Sums of disjoint ranges add up to the bits of the whole range.
    [[nodiscard]] Sums read(std::span<const Vector> directions, double half_angle_rad, const Photon_range &range,
                            unsigned threads, Watch &watch) const;

    struct Stored {
        Hit_map map;
        Balance balance;
    };
    [[nodiscard]] Stored store(const Photon_range &range, unsigned threads, Watch &watch) const;

    [[nodiscard]] double aperture_half_angle_rad() const;

private:
    [[nodiscard]] double acceptance_half_angle_rad() const;
    [[nodiscard]] Tracer tracer() const;

    Receiver_settings receiver_;
    Trace_settings trace_;
    Sample_model sample_;
    std::unique_ptr<Scene> scene_;
    std::unique_ptr<Source> source_;
    Frame lab_axes_;
};

} // namespace gonio::sim
