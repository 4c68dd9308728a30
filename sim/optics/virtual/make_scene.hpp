// make_scene.hpp: which walk a sample is traced with.
#pragma once

#include <memory>

#include "embree_scene.hpp"
#include "sample.hpp"
#include "slat_scene.hpp"

namespace gonio::sim {

enum class Walk {
    automatic, // the fast walk where the sample is a stack of slats, else Embree
    embree,
};

inline std::unique_ptr<Scene> make_scene(const Sample_model &sample, Walk walk) {
    if (walk == Walk::automatic && sample.slats) {
        return make_slat_scene(*sample.slats);
    }
    return make_embree_scene(sample.shapes);
}

} // namespace gonio::sim
