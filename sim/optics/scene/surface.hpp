// surface.hpp: the two sides of a surface: a material each, and how much the medium on each side absorbs.
#pragma once

#include "material.hpp"

namespace gonio::sim {

// Front is the side that the shape's normal points to. A material that transmits must be the same object on both sides
// (it is told which side the light comes from). Media: 0 is air; the inside of a pane, a bead, a bubble's outside.
struct Surface {
    const Material *front;
    const Material *back;
    double front_absorption_per_mm = 0.0;
    double back_absorption_per_mm = 0.0;
};

} // namespace gonio::sim
