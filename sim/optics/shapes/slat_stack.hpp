// slat_stack.hpp: equal slats of one profile, stacked at a pitch: what the fast walk needs to know.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "vector.hpp"

namespace gonio::sim {

// In the profile's plane (y, z): slats run along x, are stacked along y, z is depth.
struct Profile_line {
    double y0, z0, y1, z1; // front: to the left of the way from 0 to 1, seen from +x (y to the right, z up)
    std::uint32_t surface;
};
struct Profile_arc {
    double y, z, radius, start_rad, sweep_rad; // angle from +y towards +z; front: outside
    std::uint32_t surface;
};
using Profile_piece = std::variant<Profile_line, Profile_arc>;

struct Slat_stack {
    std::vector<Profile_piece> profile; // of the slat number 0
    double pitch;                       // slat i is shifted by i * pitch along y
    std::int32_t first;                 // number of the lowest slat
    std::uint32_t count;
    double half_length; // along x
};

class Shapes;

// The stack's shapes, slat by slat, piece by piece: lines become parallelograms, arcs arcs; tangents run along x.
void add_slats(const Slat_stack &stack, Shapes &shapes);

} // namespace gonio::sim
