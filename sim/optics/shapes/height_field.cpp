// height_field.cpp: see height_field.hpp.
#include "height_field.hpp"

#include <algorithm>
#include <stdexcept>

#include "bernstein.hpp"
#include "shapes.hpp"
#include "stretch.hpp"

namespace gonio::sim {

namespace {

using Row = std::array<double, 3>;

// From three control points of a uniform quadratic B-spline to the Bernstein coefficients of their common span.
Row span_of(double a, double b, double c) {
    return {0.5 * (a + b), b, 0.5 * (b + c)};
}

// The coefficients of the part from p to q: the quadratic's blossom at (p, p), (p, q), (q, q).
Row part_of(const Row &c, double p, double q) {
    double const first_p = c[0] + p * (c[1] - c[0]);
    double const second_p = c[1] + p * (c[2] - c[1]);
    double const first_q = c[0] + q * (c[1] - c[0]);
    double const second_q = c[1] + q * (c[2] - c[1]);
    return {first_p + p * (second_p - first_p), first_p + q * (second_p - first_p), first_q + q * (second_q - first_q)};
}

} // namespace

Ready_height_field::Ready_height_field(Height_field shape, std::uint32_t its_number)
    : number(its_number), surface(shape.surface), corner_(shape.corner), frame_(shape.frame),
      heights_(std::move(shape.heights)) {
    if (shape.rows < 3 || shape.columns < 3 || heights_.size() != std::size_t{shape.rows} * shape.columns) {
        throw std::invalid_argument("a height field needs 3 x 3 control points or more, and a height for each");
    }
    across_ = shape.columns - 2;
    along_ = shape.rows - 2;
    patch_width_ = shape.width / across_;
    patch_depth_ = shape.depth / along_;
}

Height_patch::Height_patch(const Ready_height_field &field, std::uint32_t index)
    : number(field.number + index), surface(field.surface), field_(field), column_(index % field.across_),
      row_(index / field.across_) {
    std::array<Row, 3> rows{};
    double const *point = field.heights_.data() + std::size_t{row_} * (field.across_ + 2) + column_;
    for (Row &row : rows) {
        row = span_of(point[0], point[1], point[2]);
        point += field.across_ + 2;
    }
    lowest_ = no_meeting;
    highest_ = -no_meeting;
    for (std::size_t s = 0; s < 3; ++s) {
        Row const column = span_of(rows[0][s], rows[1][s], rows[2][s]);
        for (std::size_t t = 0; t < 3; ++t) {
            heights_[t][s] = column[t];
            lowest_ = std::min(lowest_, column[t]);
            highest_ = std::max(highest_, column[t]);
        }
    }
}

// Along a ray the height of a biquadratic patch less the ray's own is of degree 4. Its coefficients on the stretch over
// the patch: those of the part of the patch below that stretch, taken along the diagonal.
double Height_patch::distance_mm(const Ray &ray) const {
    Vector const from = field_.frame_.to_local(ray.origin - field_.corner_);
    Vector const way = field_.frame_.to_local(ray.direction);
    double const left = column_ * field_.patch_width_;
    double const near = row_ * field_.patch_depth_;
    bool const leaves = ray.from == number;
    Stretch stretch{leaves ? 0.0 : least_distance_mm, no_meeting};
    stretch.clip(from.x, way.x, left - edge_mm, (column_ + 1) * field_.patch_width_ + edge_mm);
    stretch.clip(from.y, way.y, near - edge_mm, (row_ + 1) * field_.patch_depth_ + edge_mm);
    stretch.clip(from.z, way.z, lowest_ - edge_mm, highest_ + edge_mm);
    if (stretch.empty() || (leaves && stretch.begin > 0.0)) {
        return no_meeting;
    }
    Vector const a = from + stretch.begin * way;
    Vector const b = from + stretch.end * way;
    double const s_a = (a.x - left) / field_.patch_width_;
    double const s_b = (b.x - left) / field_.patch_width_;
    double const t_a = (a.y - near) / field_.patch_depth_;
    double const t_b = (b.y - near) / field_.patch_depth_;
    std::array<Row, 3> part{};
    for (std::size_t t = 0; t < 3; ++t) {
        part[t] = part_of(heights_[t], s_a, s_b);
    }
    for (std::size_t s = 0; s < 3; ++s) {
        Row const column = part_of({part[0][s], part[1][s], part[2][s]}, t_a, t_b);
        part[0][s] = column[0];
        part[1][s] = column[1];
        part[2][s] = column[2];
    }
    double const rise = 0.25 * (b.z - a.z);
    Bernstein<5> const above{{
        part[0][0] - a.z,
        0.5 * (part[0][1] + part[1][0]) - (a.z + rise),
        (part[0][2] + 4.0 * part[1][1] + part[2][0]) / 6.0 - (a.z + 2.0 * rise),
        0.5 * (part[1][2] + part[2][1]) - (a.z + 3.0 * rise),
        part[2][2] - b.z,
    }};
    double found = no_meeting;
    auto const accept = [&](double root) {
        double const distance = stretch.begin + root * (stretch.end - stretch.begin);
        bool const met = distance > least_distance_mm;
        found = met ? distance : found;
        return met;
    };
    leaves ? first_root(without_root_at_0(above), accept) : first_root(above, accept);
    return found;
}

Facing Height_patch::facing(const Vector &place) const {
    Vector const local = field_.frame_.to_local(place - field_.corner_);
    double const s = local.x / field_.patch_width_ - column_;
    double const t = local.y / field_.patch_depth_ - row_;
    Row along_s{};
    Row along_t{};
    for (std::size_t i = 0; i < 3; ++i) {
        along_s[i] = part_of({heights_[0][i], heights_[1][i], heights_[2][i]}, t, t)[0];
        along_t[i] = part_of(heights_[i], s, s)[0];
    }
    auto const slope = [](const Row &c, double x) { return 2.0 * (c[1] - c[0] + x * (c[2] - 2.0 * c[1] + c[0])); };
    double const slope_s = slope(along_s, s) / field_.patch_width_;
    double const slope_t = slope(along_t, t) / field_.patch_depth_;
    return {field_.frame_.to_world(unit({-slope_s, -slope_t, 1.0})), field_.frame_.to_world(unit({1.0, 0.0, slope_s}))};
}

Box Height_patch::bounds() const {
    const auto &field = field_;
    Vector const middle = field.frame_.to_world(
        {(column_ + 0.5) * field.patch_width_, (row_ + 0.5) * field.patch_depth_, 0.5 * (lowest_ + highest_)});
    return Box::of(field.corner_ + middle, (0.5 * field.patch_width_) * field.frame_.s,
                   (0.5 * field.patch_depth_) * field.frame_.t, (0.5 * (highest_ - lowest_)) * field.frame_.n);
}

} // namespace gonio::sim
