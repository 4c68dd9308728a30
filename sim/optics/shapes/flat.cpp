// flat.cpp: see flat.hpp.
#include "flat.hpp"

#include "shapes.hpp"

namespace gonio::sim {

Ready_parallelogram::Ready_parallelogram(const Parallelogram &shape, std::uint32_t its_number)
    : number(its_number), surface(shape.surface), half_u_(0.5 * shape.side_u), half_v_(0.5 * shape.side_v) {
    centre_ = shape.corner + half_u_ + half_v_;
    normal_ = unit(cross(shape.side_u, shape.side_v));
    tangent_ = unit(shape.side_u);
    Vector const beside_v = cross(half_v_, normal_);
    Vector const beside_u = cross(normal_, half_u_);
    across_u_ = (1.0 / dot(beside_v, half_u_)) * beside_v;
    across_v_ = (1.0 / dot(beside_u, half_v_)) * beside_u;
    // across_u_ is as long as 1 / (distance of the sides from the centre).
    most_u_ = 1.0 + edge_mm * length(across_u_);
    most_v_ = 1.0 + edge_mm * length(across_v_);
}

Box Ready_parallelogram::bounds() const {
    return Box::of(centre_, half_u_, half_v_, {});
}

Ready_disc::Ready_disc(const Disc &shape, std::uint32_t its_number)
    : number(its_number), surface(shape.surface), centre_(shape.centre), normal_(shape.normal),
      radius_(shape.outer_radius) {
    double const inner = shape.inner_radius > 0.0 ? shape.inner_radius - edge_mm : 0.0;
    double const outer = radius_ + edge_mm;
    least_square_ = inner > 0.0 ? inner * inner : 0.0;
    most_square_ = outer * outer;
    tangent_ = frame_about(normal_).s;
}

Box Ready_disc::bounds() const {
    return Box::of_circle(centre_, normal_, radius_, {});
}

Ready_triangle::Ready_triangle(const Triangle &shape, std::uint32_t its_number)
    : number(its_number), surface(shape.surface), a_(shape.a), b_(shape.b), c_(shape.c) {
    Vector const ab = b_ - a_;
    Vector const ac = c_ - a_;
    Vector const normal = cross(ab, ac);
    // A skinny triangle's edges are nearly parallel, and their product has lost digits: it is turned until it is square
    // to the longer of them again.
    Vector const edge = dot(ab, ab) > dot(ac, ac) ? ab : ac;
    normal_ = unit(normal - (dot(normal, edge) / dot(edge, edge)) * edge);
}

Box Ready_triangle::bounds() const {
    Box box;
    box.include(a_);
    box.include(b_);
    box.include(c_);
    return box;
}

} // namespace gonio::sim
