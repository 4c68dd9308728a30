// slat_scene.hpp: the fast walk through a stack of equal slats.
#pragma once

#include <memory>

#include "scene.hpp"
#include "slat_stack.hpp"

namespace gonio::sim {

// Meets the same bits and numbers the same primitives as make_embree_scene() of add_slats().
std::unique_ptr<Scene> make_slat_scene(const Slat_stack &stack);

} // namespace gonio::sim
