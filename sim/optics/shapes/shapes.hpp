// shapes.hpp: the primitives of a scene, exact surfaces all: no tessellation. Numbered in order of addition.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "flat.hpp"
#include "height_field.hpp"
#include "round.hpp"
#include "torus.hpp"
#include "vector.hpp"

namespace gonio::sim {

// Front: side_u x side_v.
struct Parallelogram {
    Vector corner;
    Vector side_u;
    Vector side_v;
    std::uint32_t surface;
};

// A ring if inner_radius > 0. Front: normal.
struct Disc {
    Vector centre;
    Vector normal; // unit
    double inner_radius;
    double outer_radius;
    std::uint32_t surface;
};

// Part of a circular cylinder: an arc, extruded. Front: outside.
struct Arc {
    Vector middle; // of the axis
    Vector axis;   // unit
    double half_length;
    double radius;
    Vector start;     // unit, across the axis, from it to the arc's begin
    double sweep_rad; // about the axis, right-handed, at most 2 pi
    std::uint32_t surface;
};

// Front: outside. A cap if least_cosine > -1: the part whose outward normal n has dot(n, pole) >= least_cosine (a
// bead's free half and its sunk half are two caps of one sphere).
struct Sphere {
    Vector centre;
    double radius;
    std::uint32_t surface;
    Vector pole{0.0, 0.0, 1.0}; // unit
    double least_cosine = -1.0;
};

// Part of a torus: a thread that bends over another. Front: outside.
struct Torus_arc {
    Vector centre;
    Vector axis;  // unit
    Vector start; // unit, across the axis
    double sweep_rad;
    double major_radius;
    double minor_radius; // less than major_radius
    std::uint32_t surface;
};

struct Triangle {
    Vector a;
    Vector b;
    Vector c; // front: (b - a) x (c - a)
    std::uint32_t surface;
};

// A smooth surface (biquadratic B-spline, continuous slope) over a rectangle: height above the plane at control points
// `rows` x `columns` (3 or more), row by row along frame.t. Front: +frame.n. Each of the (rows - 2) x (columns - 2)
// patches is a primitive; they fill the rectangle. Control points sit half a patch outside it and then a patch apart.
struct Height_field {
    Vector corner; // of the rectangle
    Frame frame;   // s: along a row, t: from row to row, n: height
    double width;  // along s
    double depth;  // along t
    std::uint32_t rows;
    std::uint32_t columns;
    std::vector<double> heights;
    std::uint32_t surface;
};

// The list; adding returns the number of the (first) primitive. Tangents: a parallelogram's along side_u, an arc's
// along its axis, a torus's along the thread, a triangle's along b - a, a height field's along frame.s.
class Shapes {
public:
    std::uint32_t add(const Parallelogram &shape) { return put(parallelograms_, shape); }
    std::uint32_t add(const Disc &shape) { return put(discs_, shape); }
    std::uint32_t add(const Arc &shape) { return put(arcs_, shape); }
    std::uint32_t add(const Sphere &shape) { return put(spheres_, shape); }
    std::uint32_t add(const Torus_arc &shape) { return put(torus_arcs_, shape); }
    std::uint32_t add(const Triangle &shape) { return put(triangles_, shape); }
    std::uint32_t add(Height_field shape) {
        std::uint32_t const first = size_;
        size_ += height_fields_.emplace_back(std::move(shape), first).patches();
        return first;
    }

    // Primitives.
    [[nodiscard]] std::uint32_t size() const { return size_; }

    // By kind, ready for rays.
    [[nodiscard]] const std::vector<Ready_parallelogram> &parallelograms() const { return parallelograms_; }
    [[nodiscard]] const std::vector<Ready_disc> &discs() const { return discs_; }
    [[nodiscard]] const std::vector<Ready_arc> &arcs() const { return arcs_; }
    [[nodiscard]] const std::vector<Ready_sphere> &spheres() const { return spheres_; }
    [[nodiscard]] const std::vector<Ready_torus_arc> &torus_arcs() const { return torus_arcs_; }
    [[nodiscard]] const std::vector<Ready_triangle> &triangles() const { return triangles_; }
    [[nodiscard]] const std::vector<Ready_height_field> &height_fields() const { return height_fields_; }

    // Around all of them.
    [[nodiscard]] Box bounds() const {
        Box box;
        auto const include = [&box](const auto &list) {
            for (const auto &shape : list) {
                box.include(shape.bounds());
            }
        };
        include(parallelograms_);
        include(discs_);
        include(arcs_);
        include(spheres_);
        include(torus_arcs_);
        include(triangles_);
        for (const Ready_height_field &field : height_fields_) {
            for (std::uint32_t patch = 0; patch < field.patches(); ++patch) {
                box.include(field.patch(patch).bounds());
            }
        }
        return box;
    }

private:
    template <class Ready, class Shape> std::uint32_t put(std::vector<Ready> &list, const Shape &shape) {
        list.emplace_back(shape, size_);
        return size_++;
    }

    std::vector<Ready_parallelogram> parallelograms_;
    std::vector<Ready_disc> discs_;
    std::vector<Ready_arc> arcs_;
    std::vector<Ready_sphere> spheres_;
    std::vector<Ready_torus_arc> torus_arcs_;
    std::vector<Ready_triangle> triangles_;
    std::vector<Ready_height_field> height_fields_;
    std::uint32_t size_ = 0;
};

} // namespace gonio::sim
