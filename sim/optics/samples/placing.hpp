// placing.hpp: angles in degrees, for where the parts of a sample go. From elementary.hpp alone, so that a sample has
// the same bits on every machine.
#pragma once

#include "elementary.hpp"

namespace gonio::sim {

inline Sine_cosine sine_cosine_of_deg(double angle_deg) {
    return sine_cosine_of_turns(angle_deg / 360.0);
}

} // namespace gonio::sim
