// flat.hpp: parallelogram, disc and triangle, ready for rays.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "ray.hpp"

namespace gonio::sim {

struct Parallelogram;
struct Disc;
struct Triangle;

// Tangent: along side_u.
class Ready_parallelogram {
public:
    Ready_parallelogram(const Parallelogram &shape, std::uint32_t number);

    [[nodiscard]] double distance_mm(const Ray &ray) const {
        Vector const towards = centre_ - ray.origin;
        double const distance = dot(normal_, towards) / dot(normal_, ray.direction);
        // In this order a ray along the plane, whose distance is infinite or no number, fails.
        if (!(distance > least_distance_mm) || ray.from == number) {
            return no_meeting;
        }
        Vector const within = distance * ray.direction - towards;
        bool const met = std::abs(dot(across_u_, within)) <= most_u_ && std::abs(dot(across_v_, within)) <= most_v_;
        return met ? distance : no_meeting;
    }
    [[nodiscard]] Facing facing(const Vector & /*place*/) const { return {normal_, tangent_}; }
    [[nodiscard]] Box bounds() const;

    std::uint32_t number;
    std::uint32_t surface;

private:
    Vector centre_;
    Vector normal_;
    Vector across_u_; // in the plane: its product with a place counts halves of side_u from the centre
    Vector across_v_;
    double most_u_; // 1 and the edge
    double most_v_;
    Vector tangent_;
    Vector half_u_;
    Vector half_v_;
};

// Tangent: some fixed direction.
class Ready_disc {
public:
    Ready_disc(const Disc &shape, std::uint32_t number);

    [[nodiscard]] double distance_mm(const Ray &ray) const {
        Vector const towards = centre_ - ray.origin;
        double const distance = dot(normal_, towards) / dot(normal_, ray.direction);
        if (!(distance > least_distance_mm) || ray.from == number) {
            return no_meeting;
        }
        Vector const within = distance * ray.direction - towards;
        double const square = dot(within, within);
        return square >= least_square_ && square <= most_square_ ? distance : no_meeting;
    }
    [[nodiscard]] Facing facing(const Vector & /*place*/) const { return {normal_, tangent_}; }
    [[nodiscard]] Box bounds() const;

    std::uint32_t number;
    std::uint32_t surface;

private:
    Vector centre_;
    Vector normal_;
    double least_square_;
    double most_square_;
    Vector tangent_;
    double radius_;
};

// Tangent: along b - a.
class Ready_triangle {
public:
    Ready_triangle(const Triangle &shape, std::uint32_t number);

    // Seen along the ray, the corners are points of a plane, and the signs of the areas that edges span with the ray
    // decide. An edge's area is the same number, sign apart, in both triangles that share it, so no ray passes between
    // them; and since the corners' places are taken relative to the ray before anything is multiplied, no triangle is
    // too skinny and no ray too grazing (Woop et al. 2013, "Watertight ray/triangle intersection"). The distance is the
    // plane's, which is good unless the ray grazes it; then the corners' own distances confine it.
    [[nodiscard]] double distance_mm(const Ray &ray) const {
        Vector const towards = a_ - ray.origin;
        Seen const a(towards, ray.direction);
        Seen const b(b_ - ray.origin, ray.direction);
        Seen const c(c_ - ray.origin, ray.direction);
        double const of_a = c.x * b.y - c.y * b.x;
        double const of_b = a.x * c.y - a.y * c.x;
        double const of_c = b.x * a.y - b.y * a.x;
        bool const one_side =
            (of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0) || (of_a <= 0.0 && of_b <= 0.0 && of_c <= 0.0);
        if (!one_side || of_a + of_b + of_c == 0.0 || ray.from == number) {
            return no_meeting;
        }
        double const nearest = std::min({a.depth, b.depth, c.depth});
        double const furthest = std::max({a.depth, b.depth, c.depth});
        double distance = dot(normal_, towards) / dot(normal_, ray.direction);
        distance = distance >= nearest ? distance : nearest;
        distance = distance <= furthest ? distance : furthest;
        return distance > least_distance_mm ? distance : no_meeting;
    }
    [[nodiscard]] Facing facing(const Vector & /*place*/) const { return {normal_, unit(b_ - a_)}; }
    [[nodiscard]] Box bounds() const;

    std::uint32_t number;
    std::uint32_t surface;

private:
    // A place relative to the ray's origin: along the ray, and beside it, sheared and scaled.
    struct Seen {
        double x;
        double y;
        double depth;

        Seen(const Vector &p, const Vector &way) : depth(dot(p, way)) {
            double const size_x = std::abs(way.x);
            double const size_y = std::abs(way.y);
            double const size_z = std::abs(way.z);
            if (size_z >= size_x && size_z >= size_y) {
                x = p.x * way.z - way.x * p.z;
                y = p.y * way.z - way.y * p.z;
            } else if (size_y >= size_x) {
                x = p.z * way.y - way.z * p.y;
                y = p.x * way.y - way.x * p.y;
            } else {
                x = p.y * way.x - way.y * p.x;
                y = p.z * way.x - way.z * p.x;
            }
        }
    };

    Vector a_;
    Vector b_;
    Vector c_;
    Vector normal_;
};

} // namespace gonio::sim
