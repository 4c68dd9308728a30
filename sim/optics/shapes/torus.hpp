// torus.hpp: part of a torus, ready for rays.
#pragma once

#include <cstdint>

#include "ray.hpp"

namespace gonio::sim {

struct Torus_arc;

// Tangent: along the thread.
class Ready_torus_arc {
public:
    Ready_torus_arc(const Torus_arc &shape, std::uint32_t number);

    [[nodiscard]] double distance_mm(const Ray &ray) const;
    [[nodiscard]] Facing facing(const Vector &place) const;
    [[nodiscard]] Box bounds() const;

    std::uint32_t number;
    std::uint32_t surface;

private:
    Vector centre_;
    Frame frame_; // s: towards the middle of the arc, n: the axis
    double major_radius_;
    double minor_radius_;
    double cosine_;       // of half the sweep
    double least_cosine_; // the same with the edge
    double sine_;         // of half the sweep, at most a quarter turn
};

} // namespace gonio::sim
