// scene_tests.hpp: the scene without a hierarchy, random shapes and rays, and the comparison of two scenes bit by bit.
#pragma once

#include <cstring>
#include <memory>
#include <vector>

#include "nearest.hpp"
#include "random.hpp"
#include "shapes.hpp"

namespace gonio::sim {

constexpr double pi = 3.14159265358979323846;

// Tries every shape.
class Brute_scene : public Scene {
public:
    explicit Brute_scene(Shapes shapes) : shapes_(std::move(shapes)) {}

    [[nodiscard]] bool closest(const Ray &ray, Hit &hit) const override {
        Nearest nearest;
        auto const try_each = [&](const auto &list) {
            for (const auto &shape : list) {
                if (nearest.offer(shape.distance_mm(ray), shape.number)) {
                    describe(shape, ray, nearest.distance_mm, hit);
                }
            }
        };
        try_each(shapes_.parallelograms());
        try_each(shapes_.discs());
        try_each(shapes_.arcs());
        try_each(shapes_.spheres());
        try_each(shapes_.torus_arcs());
        try_each(shapes_.triangles());
        for (const Ready_height_field &field : shapes_.height_fields()) {
            std::vector<Height_patch> patches;
            for (std::uint32_t i = 0; i < field.patches(); ++i) {
                patches.push_back(field.patch(i));
            }
            try_each(patches);
        }
        return nearest.distance_mm < no_meeting;
    }

private:
    Shapes shapes_;
};

class Dice {
public:
    explicit Dice(std::uint64_t seed) : random_(seed, 0) {}

    double between(double low, double high) { return low + (high - low) * random_.uniform(); }
    std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(random_.uniform() * count); }
    Vector direction() {
        double const z = between(-1.0, 1.0);
        double const angle = between(0.0, 2.0 * pi);
        double const across = std::sqrt(1.0 - z * z);
        return {across * std::cos(angle), across * std::sin(angle), z};
    }
    Vector place(double half) { return {between(-half, half), between(-half, half), between(-half, half)}; }
    // From a surface, to either side; every other one grazing.
    Vector from_surface(const Vector &normal) {
        Vector const any = direction();
        Vector const flat = any - dot(any, normal) * normal;
        double const rise = below(2) == 0 ? std::pow(10.0, between(-9.0, 0.0)) : between(0.0, 2.0);
        return unit(unit(flat) + (below(2) == 0 ? rise : -rise) * normal);
    }

private:
    Photon_random random_;
};

// Some of each kind within `half` of the origin.
inline Shapes random_shapes(Dice &dice, std::uint32_t of_each, double half) {
    Shapes shapes;
    double const size = 0.2 * half;
    for (std::uint32_t i = 0; i < of_each; ++i) {
        Frame const frame =
            i % 4 == 0 ? Frame{{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}} : frame_about(dice.direction());
        auto const place = [&]() { return dice.place(half - 2.0 * size); };
        auto const scale = [&]() { return size * dice.between(0.05, 1.0); };
        shapes.add(Parallelogram{place(), scale() * frame.s, scale() * frame.t, i});
        shapes.add(Disc{place(), frame.n, i % 2 == 0 ? 0.0 : 0.02 * size, scale(), i});
        double const sweep = i % 3 == 0 ? 2.0 * pi : dice.between(0.1, 6.0);
        shapes.add(Arc{place(), frame.n, scale(), scale(), frame.s, sweep, i});
        shapes.add(Sphere{place(), scale(), i});
        shapes.add(Torus_arc{place(), frame.n, frame.s, sweep, 0.7 * size, 0.6 * scale(), i});
        Vector const a = place();
        Vector const b = a + size * dice.direction();
        // Every other one is skinny.
        Vector const c = i % 2 == 0 ? a + size * dice.direction() : b + (1e-4 * size) * dice.direction();
        shapes.add(Triangle{a, b, c, i});
    }
    Height_field field{{-0.5 * half, -0.5 * half, 0.0}, frame_about(unit({0.1, 0.2, 1.0})), half, half, 7, 8, {}, 77};
    for (std::uint32_t i = 0; i < field.rows * field.columns; ++i) {
        field.heights.push_back(dice.between(0.0, 0.1 * half));
    }
    shapes.add(field);
    return shapes;
}

// Same answer, to the last bit (a zero's sign apart).
inline bool same(bool met, const Hit &hit, bool other_met, const Hit &other) {
    return met == other_met &&
           (!met || (hit.distance_mm == other.distance_mm && hit.primitive == other.primitive &&
                     hit.surface == other.surface && hit.normal == other.normal && hit.tangent == other.tangent));
}

// Follows rays through `reference` and compares each step with `other`: how many steps differ.
inline int differences(const Scene &reference, const Scene &other, Dice &dice, Ray ray, int steps) {
    int count = 0;
    for (int step = 0; step < steps; ++step) {
        Hit hit{};
        Hit its{};
        bool const met = reference.closest(ray, hit);
        count += same(met, hit, other.closest(ray, its), its) ? 0 : 1;
        if (!met) {
            break;
        }
        ray = {ray.at(hit.distance_mm), dice.from_surface(hit.normal), hit.primitive};
    }
    return count;
}

} // namespace gonio::sim
