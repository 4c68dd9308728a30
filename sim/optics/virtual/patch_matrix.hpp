// patch_matrix.hpp: light from all of a patch of directions on one period of the sample, counted by the patch that it
// leaves through: a column of the BSDF matrix, without any direction standing for its patch.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "estimate.hpp"
#include "photon_scenario.hpp"
#include "virtual_goniophotometer.hpp"

namespace gonio::sim {

// Directions theta in [theta_low, theta_high), azimuth from phi_low on, phi_width wide, in degrees, of a hemisphere
// about a side's normal. phi in the sample frame on both sides: about +z.
struct Patch {
    double theta_low_deg;
    double theta_high_deg;
    double phi_low_deg;
    double phi_width_deg;
};

class Patch_matrix {
public:
    // The patches of a hemisphere; they must not overlap, and all patches of one theta range must be of equal width (as
    // in the Klems bases). The same set is used for the incident and both outgoing hemispheres. A scenario with
    // something that surrounds the sample is refused: no light of a whole patch passes through it. Throws Input_error.
    Patch_matrix(const Photon_scenario &scenario, const Band &band, std::vector<Patch> patches,
                 Walk walk = Walk::automatic);

    struct Column {
        Aperture_sums reflected;   // per outgoing patch on the lit side
        Aperture_sums transmitted; // per outgoing patch on the other side
        Balance balance;
    };
    // Light whose incident direction lies in the patch, drawn in proportion to cos(theta), uniform over the sample's
    // cell. weight sum / photons = integral of the DSF over the outgoing patch, averaged over the incident one.
    [[nodiscard]] Column column(std::size_t incident_patch, bool front_lit, const Photon_range &range, unsigned threads,
                                Watch &watch) const;
    // From the frontmost to the rearmost point of the sample.
    [[nodiscard]] double depth_mm() const;

private:
    Trace_settings trace_;
    std::vector<Patch> patches_;
    Sample_model sample_;
    std::unique_ptr<Scene> scene_;
};

} // namespace gonio::sim
