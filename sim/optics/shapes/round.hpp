// round.hpp: arc (part of a circular cylinder) and sphere, ready for rays.
//
// The discriminant is taken from the ray's distance to the centre, not from b^2 - ac, so that a far origin costs no
// digits (Haines et al. 2019, "Precision improvements for ray/sphere intersection"). If the ray leaves the shape
// itself, one root is its start: set to 0 exactly, the other is then -2b, with all its digits.
#pragma once

#include <cmath>
#include <cstdint>

#include "ray.hpp"

namespace gonio::sim {

struct Arc;
struct Sphere;

// Tangent: along the axis.
class Ready_arc {
public:
    Ready_arc(const Arc &shape, std::uint32_t number);

    [[nodiscard]] double distance_mm(const Ray &ray) const {
        Vector const from = across_.to_local(ray.origin - middle_);
        Vector const way = across_.to_local(ray.direction);
        double const a = way.x * way.x + way.y * way.y;
        double const b = from.x * way.x + from.y * way.y;
        // A ray along the axis: no number, which fails every comparison below.
        double const per_a = 1.0 / a;
        if (ray.from == number) {
            return within(from, way, -2.0 * b * per_a);
        }
        double const beside = way.x * from.y - way.y * from.x;
        double const discriminant = radius_ * radius_ * a - beside * beside;
        if (!(discriminant >= 0.0)) {
            return no_meeting;
        }
        double const root = std::sqrt(discriminant);
        double const second = (root - b) * per_a;
        if (!(second > least_distance_mm)) {
            return no_meeting;
        }
        double const first = within(from, way, (-root - b) * per_a);
        return first < no_meeting ? first : within(from, way, second);
    }
    [[nodiscard]] Facing facing(const Vector &place) const {
        Vector const local = across_.to_local(place - middle_);
        return {unit(local.x * across_.s + local.y * across_.t), across_.n};
    }
    [[nodiscard]] Box bounds() const;

    std::uint32_t number;
    std::uint32_t surface;

private:
    [[nodiscard]] double within(const Vector &from, const Vector &way, double distance) const {
        double const towards_mid = (from.x + distance * way.x) * mid_x_ + (from.y + distance * way.y) * mid_y_;
        bool const met = distance > least_distance_mm && towards_mid >= least_towards_mid_ &&
                         std::abs(from.z + distance * way.z) <= half_length_;
        return met ? distance : no_meeting;
    }

    Vector middle_;
    Frame across_; // n: the axis
    double radius_;
    double mid_x_; // unit, towards the middle of the arc
    double mid_y_;
    double least_towards_mid_; // radius * cosine of half the sweep
    double half_length_;
    double cosine_; // of half the sweep
    double sine_;   // of half the sweep, at most a quarter turn
};

// Tangent: some direction.
class Ready_sphere {
public:
    Ready_sphere(const Sphere &shape, std::uint32_t number);

    [[nodiscard]] double distance_mm(const Ray &ray) const {
        Vector const from = ray.origin - centre_;
        double const b = dot(from, ray.direction);
        if (ray.from == number) {
            return within(from, ray.direction, -2.0 * b);
        }
        Vector const beside = from - b * ray.direction;
        double const discriminant = radius_ * radius_ - dot(beside, beside);
        if (!(discriminant >= 0.0)) {
            return no_meeting;
        }
        double const root = std::sqrt(discriminant);
        double const first = within(from, ray.direction, -root - b);
        return first < no_meeting ? first : within(from, ray.direction, root - b);
    }
    [[nodiscard]] Facing facing(const Vector &place) const {
        Vector const normal = unit(place - centre_);
        return {normal, frame_about(normal).s};
    }
    [[nodiscard]] Box bounds() const;

    std::uint32_t number;
    std::uint32_t surface;

private:
    [[nodiscard]] double within(const Vector &from, const Vector &way, double distance) const {
        bool const met =
            distance > least_distance_mm && dot(from, pole_) + distance * dot(way, pole_) >= least_along_pole_;
        return met ? distance : no_meeting;
    }

    Vector centre_;
    double radius_;
    Vector pole_;
    double least_along_pole_; // of a cap; below -radius: the whole sphere
};

} // namespace gonio::sim
