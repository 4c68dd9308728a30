// shapes.hpp: the primitives of a scene, exact surfaces all: no tessellation. Numbered in order of addition.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

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
    Vector start;    // unit, across the axis, from it to the arc's begin
    double sweep_rad; // about the axis, right-handed, at most 2 pi
    std::uint32_t surface;
};

// Front: outside.
struct Sphere {
    Vector centre;
    double radius;
    std::uint32_t surface;
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
// `rows` x `columns`, row by row along frame.t. Front: +frame.n. Each patch is a primitive.
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

// The list; adding returns the number of the (first) primitive.
class Shapes {
public:
    std::uint32_t add(const Parallelogram &shape);
    std::uint32_t add(const Disc &shape);
    std::uint32_t add(const Arc &shape);
    std::uint32_t add(const Sphere &shape);
    std::uint32_t add(const Torus_arc &shape);
    std::uint32_t add(const Triangle &shape);
    std::uint32_t add(Height_field shape);
};

} // namespace gonio::sim
