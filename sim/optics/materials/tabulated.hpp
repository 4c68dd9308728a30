// tabulated.hpp: a material from data: a BSDF that was measured or computed, as a table to draw from.
#pragma once

#include <string>
#include <vector>

#include "material.hpp"

namespace gonio::sim {

// DSF for a few incident directions on one side. Outgoing: `cells` x `cells` squares per hemisphere in the Shirley-Chiu
// map of the direction cosines (x, y): cells of equal projected solid angle pi / cells^2.
struct Scatter_table {
    enum class Follow { none, mirror, retro, through };
    struct Distribution {
        double theta_deg; // of the incident direction, 0 to 90 from the side's normal
        double phi_deg;
        std::vector<double> reflected;   // BSDF [1/sr] per cell, row by row (y, then x); empty: none
        std::vector<double> transmitted; // the same, seen in (x, y) of the same frame
    };
    std::uint32_t cells = 64;
    // Between incident directions the distribution is shifted in direction cosines with this direction: a peak moves.
    Follow follow = Follow::none;
    bool isotropic = true; // only theta counts; the table is turned to the photon's azimuth
    std::vector<Distribution> front;
    std::vector<Distribution> back; // empty: as the front
};

} // namespace gonio::sim
