// embree_scene.hpp: the general scene, over Embree's hierarchy.
#pragma once

#include <memory>

#include "scene.hpp"
#include "shapes.hpp"

namespace gonio::sim {

// Keeps a copy of the shapes. Throws std::runtime_error if Embree fails.
std::unique_ptr<Scene> make_embree_scene(Shapes shapes);

} // namespace gonio::sim
