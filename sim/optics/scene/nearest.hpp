// nearest.hpp: the best meeting so far, and how it becomes a hit. The rule of scene.hpp, in one place for every scene.
#pragma once

#include "scene.hpp"

namespace gonio::sim {

struct Nearest {
    double distance_mm = no_meeting;
    std::uint32_t number = 0;

    // Whether it is now the best.
    bool offer(double distance, std::uint32_t its_number) {
        bool const better = distance < distance_mm || (distance == distance_mm && its_number < number);
        if (better) {
            distance_mm = distance;
            number = its_number;
        }
        return better;
    }
};

template <class Ready> void describe(const Ready &shape, const Ray &ray, double distance_mm, Hit &hit) {
    Facing const facing = shape.facing(ray.at(distance_mm));
    hit = {distance_mm, facing.normal, facing.tangent, shape.surface, shape.number};
}

} // namespace gonio::sim
