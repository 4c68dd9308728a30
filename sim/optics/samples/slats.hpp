// slats.hpp: a stack of equal slats, as shapes and for the fast walk.
#pragma once

#include "sample_parts.hpp"

namespace gonio::sim {

// How many, and how long. The stack is centred on y = offset_mm.
struct Stack {
    double pitch_mm;
    double offset_mm;
    double length_mm; // along x
    std::uint32_t count;
};

// Keys: pitch_mm, offset_mm, length_mm, count.
Stack read_stack(Toml_table &table, double pitch_mm, std::uint32_t count);

// `profile`: of a slat whose outer edge lies at y = 0.
void stack_slats(Sample_parts &parts, const std::vector<Profile_piece> &profile, const Stack &stack);

// A piece of slat from one point of the profile to another, further inwards, sagging by `sagitta_mm` below the chord
// (negative: arched above it). The light falls on its top.
struct Slat_surfaces {
    std::uint32_t top_in_front;    // front: top
    std::uint32_t bottom_in_front; // front: bottom
};
struct Profile_point {
    double y;
    double z;
};
Profile_piece slat_section(const Profile_point &outer, const Profile_point &inner, double sagitta_mm,
                           const Slat_surfaces &surfaces);

} // namespace gonio::sim
