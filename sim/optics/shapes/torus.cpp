// torus.cpp: see torus.hpp.
#include "torus.hpp"

#include "bernstein.hpp"
#include "shapes.hpp"
#include "stretch.hpp"
#include "sweep.hpp"

namespace gonio::sim {

namespace {

// Coefficients of degree 2 of a product of what is a at 0 and b at 1, linear between, with itself.
std::array<double, 3> square(double a, double b) {
    return {a * a, a * b, b * b};
}

} // namespace

Ready_torus_arc::Ready_torus_arc(const Torus_arc &shape, std::uint32_t its_number)
    : number(its_number), surface(shape.surface), centre_(shape.centre), major_radius_(shape.major_radius),
      minor_radius_(shape.minor_radius) {
    Sweep const sweep = sweep_about(shape.axis, shape.start, shape.sweep_rad, edge_mm / major_radius_);
    frame_ = {sweep.mid, cross(shape.axis, sweep.mid), shape.axis};
    cosine_ = sweep.cosine;
    least_cosine_ = sweep.least_cosine;
    sine_ = sweep.widest_sine;
}

// (p.p + R^2 - r^2)^2 = 4 R^2 (p.p - (p.axis)^2), on the stretch of the ray within the torus's box: there p is as short
// as the torus allows, whatever the distance to the origin.
double Ready_torus_arc::distance_mm(const Ray &ray) const {
    Vector const from = frame_.to_local(ray.origin - centre_);
    Vector const way = frame_.to_local(ray.direction);
    // A little more than the torus, so that its crest is not where the stretch begins.
    double const above = (1.0 + 1e-3) * minor_radius_;
    double const reach = major_radius_ + above;
    bool const leaves = ray.from == number;
    Stretch stretch{leaves ? 0.0 : least_distance_mm, no_meeting};
    stretch.clip(from.z, way.z, -above, above);
    stretch.clip(from.x, way.x, -reach, reach);
    stretch.clip(from.y, way.y, -reach, reach);
    if (stretch.empty()) {
        return no_meeting;
    }
    Vector const a = from + stretch.begin * way;
    Vector const b = from + stretch.end * way;
    auto const x = square(a.x, b.x);
    auto const y = square(a.y, b.y);
    auto const z = square(a.z, b.z);
    double const offset = (major_radius_ - minor_radius_) * (major_radius_ + minor_radius_);
    std::array<double, 3> flat{};
    std::array<double, 3> sum{};
    for (std::size_t i = 0; i < 3; ++i) {
        flat[i] = x[i] + y[i];
        sum[i] = flat[i] + z[i] + offset;
    }
    double const four = 4.0 * major_radius_ * major_radius_;
    Bernstein<5> const torus{{
        sum[0] * sum[0] - four * flat[0],
        sum[0] * sum[1] - four * (0.5 * flat[0] + 0.5 * flat[1]),
        (sum[0] * sum[2] + 2.0 * sum[1] * sum[1]) / 3.0 - four * ((flat[0] + 4.0 * flat[1] + flat[2]) / 6.0),
        sum[1] * sum[2] - four * (0.5 * flat[1] + 0.5 * flat[2]),
        sum[2] * sum[2] - four * flat[2],
    }};
    double found = no_meeting;
    auto const accept = [&](double root) {
        double const distance = stretch.begin + root * (stretch.end - stretch.begin);
        double const s = from.x + distance * way.x;
        double const t = from.y + distance * way.y;
        bool const met = distance > least_distance_mm && s >= least_cosine_ * std::sqrt(s * s + t * t);
        found = met ? distance : found;
        return met;
    };
    leaves ? first_root(without_root_at_0(torus), accept) : first_root(torus, accept);
    return found;
}

Facing Ready_torus_arc::facing(const Vector &place) const {
    Vector const local = frame_.to_local(place - centre_);
    double const per_length = 1.0 / std::sqrt(local.x * local.x + local.y * local.y);
    Vector const outwards{local.x * per_length, local.y * per_length, 0.0};
    Vector const normal = unit(local - major_radius_ * outwards);
    return {frame_.to_world(normal), frame_.to_world({-outwards.y, outwards.x, 0.0})};
}

Box Ready_torus_arc::bounds() const {
    double const reach = major_radius_ + minor_radius_;
    double const nearest = cosine_ * (cosine_ < 0.0 ? reach : major_radius_ - minor_radius_);
    return Box::of(centre_ + (0.5 * (reach + nearest)) * frame_.s, (0.5 * (reach - nearest)) * frame_.s,
                   (reach * sine_) * frame_.t, minor_radius_ * frame_.n)
        .cut(Box::of_circle(centre_, frame_.n, major_radius_, {minor_radius_, minor_radius_, minor_radius_}));
}

} // namespace gonio::sim
