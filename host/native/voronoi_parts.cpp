// voronoi_parts.cpp: the part of a cell within the reach of its point: right triangles and sectors of a cap.
#include "voronoi_parts.hpp"

#include <algorithm>

namespace gonio::sphere {
namespace {

struct Frame {
    Vec a;
    Vec outwards; // from a to the middle of ab
    Vec left;
    Vec inwards; // the normal of the bisector, towards a
    double half;
    double reach;
};

// From the middle of ab to the arc beta, signed as beta.
Part from_middle(const Frame &f, double beta) {
    const double sin_h = std::sin(f.half);
    const double cos_h = std::cos(f.half);
    const double cos_reach = std::cos(f.reach);
    const double most = f.half < f.reach ? std::acos(std::clamp(cos_reach / std::max(cos_h, 1e-300), -1.0, 1.0)) : 0.0;
    const double beta_in = std::copysign(std::min(std::fabs(beta), most), beta);
    const double angle = std::atan2(std::sin(beta), std::cos(beta) * sin_h);
    const double angle_in = std::atan2(std::sin(beta_in), std::cos(beta_in) * sin_h);
    Part part;
    part.area = 2.0 * std::atan2(std::sin(0.5 * f.half) * std::sin(0.5 * beta_in),
                                 std::cos(0.5 * f.half) * std::cos(0.5 * beta_in)) +
                (angle - angle_in) * (1.0 - cos_reach);
    // The first moment of a polygon on the sphere is half the sum of its arcs times the unit normals of their planes,
    // inwards (J. H. Lambert, Photometria, 1760); the side from the middle back to a, the same for both ends of an
    // edge, is left out.
    const double hypotenuse = std::acos(std::clamp(cos_h * std::cos(beta_in), -1.0, 1.0));
    const double slope = 0.5 * (f.reach - std::sin(f.reach) * cos_reach);
    const double sin_reach = std::sin(f.reach);
    part.moment =
        0.5 * beta_in * f.inwards +
        (0.5 * hypotenuse * std::sin(angle_in) + slope * (std::sin(angle) - std::sin(angle_in))) * f.outwards +
        (-0.5 * hypotenuse * std::cos(angle_in) - slope * (std::cos(angle) - std::cos(angle_in))) * f.left +
        0.5 * sin_reach * sin_reach * (angle - angle_in) * f.a;
    return part;
}

Vec unit_or(const Vec &v, const Vec &otherwise) {
    const double size = length(v);
    return size > 1e-150 ? (1.0 / size) * v : otherwise;
}

} // namespace

Part part_within(const Vec &a, const Vec &b, double begin, double end, double reach) {
    const Vec chord = b - a;
    const double size = length(chord);
    const Vec left = unit_or(cross(a, b), {});
    const Frame frame{a, unit_or(cross(left, a), {}), left, (-1.0 / size) * chord, angle_of_chord(size) * 0.5, reach};
    Part part = from_middle(frame, end);
    const Part first = from_middle(frame, begin);
    part.area -= first.area;
    part.moment -= first.moment;
    if (end - begin < -0.5 * PI) { // once round: the far side of the circle lies between
        part.area += 2.0 * from_middle(frame, PI).area;
        part.moment += from_middle(frame, PI).moment;
        part.moment -= from_middle(frame, -PI).moment;
    }
    return part;
}

} // namespace gonio::sphere
