// round.cpp: see round.hpp.
#include "round.hpp"

#include "shapes.hpp"
#include "sweep.hpp"

namespace gonio::sim {

namespace {

// Two axes across a cylinder's. For one along x they are y and z themselves, so that what runs along x (slats) is
// computed without rounding by the turn.
Frame across(const Vector &axis) {
    return axis == Vector{1.0, 0.0, 0.0} ? Frame{{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, axis} : frame_about(axis);
}

} // namespace

Ready_arc::Ready_arc(const Arc &shape, std::uint32_t its_number)
    : number(its_number), surface(shape.surface), middle_(shape.middle), across_(across(shape.axis)),
      radius_(shape.radius), half_length_(shape.half_length + edge_mm) {
    Sweep const sweep = sweep_about(shape.axis, shape.start, shape.sweep_rad, edge_mm / radius_);
    Vector const mid = across_.to_local(sweep.mid);
    mid_x_ = mid.x;
    mid_y_ = mid.y;
    least_towards_mid_ = radius_ * sweep.least_cosine;
    cosine_ = sweep.cosine;
    sine_ = sweep.widest_sine;
}

Box Ready_arc::bounds() const {
    Vector const mid = mid_x_ * across_.s + mid_y_ * across_.t;
    Vector const beside = mid_x_ * across_.t + -mid_y_ * across_.s;
    return Box::of(middle_ + (0.5 * radius_ * (1.0 + cosine_)) * mid, (0.5 * radius_ * (1.0 - cosine_)) * mid,
                   (radius_ * sine_) * beside, half_length_ * across_.n)
        .cut(Box::of_circle(middle_, across_.n, radius_, half_length_ * across_.n));
}

Ready_sphere::Ready_sphere(const Sphere &shape, std::uint32_t its_number)
    : number(its_number), surface(shape.surface), centre_(shape.centre), radius_(shape.radius), pole_(shape.pole),
      least_along_pole_(shape.least_cosine > -1.0 ? radius_ * shape.least_cosine - edge_mm : -2.0 * radius_) {}

Box Ready_sphere::bounds() const {
    return Box::of(centre_, {radius_, 0.0, 0.0}, {0.0, radius_, 0.0}, {0.0, 0.0, radius_});
}

} // namespace gonio::sim
