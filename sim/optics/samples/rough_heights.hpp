// rough_heights.hpp: a random surface as a height field, the same for the same seed everywhere.
#pragma once

#include "pane.hpp"

namespace gonio::sim {

// Over width x depth of a face; flat along the rim.
Height_field rough_face(const Vector &corner, const Frame &frame, double width, double depth,
                        const Roughness &roughness, std::uint32_t surface);

} // namespace gonio::sim
