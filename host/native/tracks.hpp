// tracks.hpp: how far apart the tracks of a flown path lie, from the neighbours in a triangulation.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parts.hpp"

namespace gonio::sphere {

// The rules of host/gonio/geometry/pitch.py.
struct Track_rules {
    double round_about;
    double abeam;
    double parallel;
    double same_track_rad;
    double one_sided;
};

// Where the points in the order flown are, and which way they move.
struct Track {
    std::span<const Vec> unit;
    std::span<const Vec> ahead;         // unit tangents
    std::span<const double> length;     // along the path
    std::span<const std::int64_t> path; // its number
};

// Distance of each point's track to the next one, in rad; infinite where there is none.
std::vector<double> track_distances(const Track &track, const Track_rules &rules);

// The largest of a point's pitch and those of its neighbours in the triangulation of its hemisphere that are no farther
// than `factor` times their pitch.
std::vector<double> coarsest_pitch(std::span<const Vec> unit, std::span<const double> pitch, double factor);

} // namespace gonio::sphere
