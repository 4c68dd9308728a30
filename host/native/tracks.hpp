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
};

// Where the points in the order flown are, and which way they move.
struct Track {
    std::span<const Vec> unit;
    std::span<const Vec> ahead;         // unit tangents
    std::span<const double> length;     // along the path
    std::span<const std::int64_t> path; // its number
};

// What lies beside a point's track; infinite where nothing does.
struct Beside {
    double near; // distance of the nearer of the tracks at both sides, in rad
    double far;
    double way; // along the path to the nearer; infinite to another path
};

std::vector<Beside> track_distances(const Track &track, const Track_rules &rules);

} // namespace gonio::sphere
