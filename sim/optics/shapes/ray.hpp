// ray.hpp: a ray, and what every shape that is ready for rays says of itself: a distance, how it faces, its bounds.
#pragma once

#include <cstdint>
#include <limits>

#include "vector.hpp"

namespace gonio::sim {

inline constexpr std::uint32_t no_primitive = 0xFFFFFFFFU;

struct Ray {
    Vector origin;
    Vector direction;                  // unit
    std::uint32_t from = no_primitive; // number of the primitive that the ray leaves

    [[nodiscard]] Vector at(double distance_mm) const { return origin + distance_mm * direction; }
};

// A ray does not meet anything nearer than this; flat primitives never meet a ray that leaves them.
inline constexpr double least_distance_mm = 1e-7;

// Edges of shapes reach this much further than they are drawn, so that no ray slips between two that share an edge.
// More than the rounding of coordinates up to 2000 mm, less than any optics.
inline constexpr double edge_mm = 1e-9;

// What distance_mm() of a shape says if there is no meeting.
inline constexpr double no_meeting = std::numeric_limits<double>::infinity();

struct Facing {
    Vector normal;  // unit, of the front side
    Vector tangent; // unit, in the surface
};

struct Box {
    Vector low{no_meeting, no_meeting, no_meeting};
    Vector high{-no_meeting, -no_meeting, -no_meeting};

    void include(const Vector &place) {
        low = {least(low.x, place.x), least(low.y, place.y), least(low.z, place.z)};
        high = {most(high.x, place.x), most(high.y, place.y), most(high.z, place.z)};
    }
    void include(const Box &box) {
        include(box.low);
        include(box.high);
    }
    // About `centre`, with half axes that need not be square to each other.
    static Box of(const Vector &centre, const Vector &a, const Vector &b, const Vector &c) {
        Vector const half{std::abs(a.x) + std::abs(b.x) + std::abs(c.x), std::abs(a.y) + std::abs(b.y) + std::abs(c.y),
                          std::abs(a.z) + std::abs(b.z) + std::abs(c.z)};
        return {centre - half, centre + half};
    }

    // What lies in both.
    [[nodiscard]] Box cut(const Box &box) const {
        return {{most(low.x, box.low.x), most(low.y, box.low.y), most(low.z, box.low.z)},
                {least(high.x, box.high.x), least(high.y, box.high.y), least(high.z, box.high.z)}};
    }
    // About a circle, with some thickness around.
    static Box of_circle(const Vector &centre, const Vector &axis, double radius, const Vector &thickness) {
        Vector const half{radius * std::sqrt(square_across(axis.x)) + std::abs(thickness.x),
                          radius * std::sqrt(square_across(axis.y)) + std::abs(thickness.y),
                          radius * std::sqrt(square_across(axis.z)) + std::abs(thickness.z)};
        return {centre - half, centre + half};
    }

private:
    static double square_across(double along) { return along * along < 1.0 ? 1.0 - along * along : 0.0; }
    static double least(double a, double b) { return a < b ? a : b; }
    static double most(double a, double b) { return a > b ? a : b; }
};

} // namespace gonio::sim
