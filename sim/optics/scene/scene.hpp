// scene.hpp: rays and the surfaces that they meet. Lengths in mm, sample frame, origin in the middle of the front face.
#pragma once

#include <cstdint>

#include "ray.hpp"

namespace gonio::sim {

struct Hit {
    double distance_mm;      // along the ray, more than least_distance_mm
    Vector normal;           // unit, of the front side
    Vector tangent;          // unit, in the surface, across the normal: the direction of finishes
    std::uint32_t surface;   // index into the sample's surfaces
    std::uint32_t primitive; // number in the scene: in order of addition
};

// Which primitive is met first, computed in double precision, so that every implementation finds the same bits: the
// smallest distance wins, and of equal ones the lowest primitive number.
class Scene {
public:
    virtual ~Scene() = default;
    // False: the ray leaves. Thread-safe.
    [[nodiscard]] virtual bool closest(const Ray &ray, Hit &hit) const = 0;
};

} // namespace gonio::sim
