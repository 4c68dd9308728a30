// can_bits.hpp: how many bit times a classic data frame with an 11-bit identifier takes, stuff bits counted exactly.
#pragma once

#include "can.h"

namespace gonio::sim {

// From start of frame to end of frame (ISO 11898-1), without the intermission.
unsigned can_frame_bits(const gn_can_frame &frame);

constexpr unsigned can_intermission_bits = 3;

} // namespace gonio::sim
