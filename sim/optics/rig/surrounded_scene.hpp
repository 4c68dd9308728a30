// surrounded_scene.hpp: a sample's scene that stands off the receiver's centre, among the parts of a rig.
#pragma once

#include <memory>

#include "scene.hpp"
#include "shapes.hpp"

namespace gonio::sim {

// Origin: the receiver's centre. The sample's origin is at `sample_at`, its axes are parallel. The rig's primitives
// come first in the numbers, and so win a tie.
std::unique_ptr<Scene> make_surrounded_scene(const Shapes &rig, std::unique_ptr<Scene> sample, const Vector &sample_at);

} // namespace gonio::sim
