// direction_index.hpp: the detector's directions, indexed on the sphere, so that photons stream through: each hit adds to
// the few apertures that contain it, and no photon is kept.
#pragma once

#include <span>

#include "estimate.hpp"
#include "tracer.hpp"

namespace gonio::sim {

class Direction_index final : public Hit_sink {
public:
    // Unit vectors of the sample frame to the apertures' centres. `acceptance_half_angle_rad`: light that arrives farther
    // from the aperture's normal is not seen (pi: all is).
    Direction_index(std::span<const Vector> directions, double half_angle_rad, double acceptance_half_angle_rad,
                    unsigned workers);
    void take(std::span<const Receiver_hit> hits, unsigned worker) override;
    // Over all workers, in the order of the directions.
    [[nodiscard]] Aperture_sums sums() const;
};

} // namespace gonio::sim
