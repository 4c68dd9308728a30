// splitter_rig.hpp: the extension for retro-reflection of paper [0] (sections 2.3 and 3.1, figs 5 and 6): two equal
// plate beam splitters, one in the centre of the arm's turns, the sample behind it.
//
// Lab frame. The first splitter stands on edge at the centre, at 45 degrees: light goes through it to the sample, comes
// back, and is reflected to the detector at +X. For reference the source's light is reflected by it towards -X, and
// goes through the second, which stands beside it at a right angle, to the detector there. Each path passes one
// splitter and is reflected by one: T R against R T.
#pragma once

#include <memory>

#include "photon_scenario.hpp"

namespace gonio::sim {

struct Splitter_rig {
    double sample_distance_mm = 105.0; // from the centre back to the sample's front
    double side_mm = 100.0;            // of a splitter, square
    bool baffle = true; // a black plate beside the sample: no light goes straight from it to the detector
};

// How far the splitters reach from the centre towards the sample.
double splitter_depth_mm(const Splitter_rig &rig);

// How the detector on its sphere sees the sample in the first splitter.
struct Splitter_view {
    Vector outgoing;    // unit, from the sample to the detector's mirror image
    double distance_mm; // of that way
    // What r^2 E / P_i is to be multiplied by to be the sample's DSF, besides the splitters' own loss: the way is
    // longer than the arm, and arrives inclined to the detector. Slip S11: paper [0] eq. 2 corrects the direction
    // alone.
    double dsf_factor;
};

// `detector`: unit, from the centre of the arm's turns. Exact; eq. 2 of paper [0] takes distance_mm as arm radius plus
// sample distance in all directions.
Splitter_view seen_in_splitter(const Splitter_rig &rig, const Vector &detector, double arm_radius_mm);

// Where a direction of the sample is seen: the detector's direction on the sphere. The inverse of the above.
Vector seen_from_sample(const Splitter_rig &rig, const Vector &outgoing, double arm_radius_mm);

// Puts the splitters around a scenario's sample; `plate` makes their material anew for a band. Light is then traced
// with its polarisation: the two paths are equal for s and for p, not for their mean (slip S12). Directions keep the
// sample's frame; their origin is the centre of the arm's turns.
void surround_with_splitters(Photon_scenario &scenario, const Splitter_rig &rig,
                             const std::function<std::unique_ptr<Material>(const Band &band)> &plate);

} // namespace gonio::sim
