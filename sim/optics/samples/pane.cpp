// pane.cpp: a solid pane: two faces, each smooth or a height field, and four black rims.
#include "pane.hpp"

#include <algorithm>
#include <cmath>

#include "placing.hpp"
#include "rough_heights.hpp"

namespace gonio::sim {
namespace {

// A face as seen from outside: the corner from which s and t run.
void add_face(Sample_parts &parts, const Vector &corner, const Frame &frame, double width, double depth,
              const Roughness &roughness, std::uint32_t surface) {
    if (roughness.rms_mm > 0.0) {
        parts.shapes().add(rough_face(corner, frame, width, depth, roughness, surface));
    } else {
        parts.shapes().add(Parallelogram{corner, width * frame.s, depth * frame.t, surface});
    }
}

} // namespace

void add_pane(Sample_parts &parts, const Pane &pane, const Material &front, const Material &back) {
    auto const [width, height] = pane.size_mm;
    double const x = 0.5 * width;
    double const y = 0.5 * height;
    double const slope = pane.wedge.sine / pane.wedge.cosine;
    double const top_z = pane.front_z_mm;
    double const thin_z = top_z - pane.thickness_mm + y * slope;  // back rim at -y
    double const thick_z = top_z - pane.thickness_mm - y * slope; // at +y

    add_face(parts, {-x, -y, top_z}, {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, width, height, pane.front,
             parts.boundary(front));
    Frame const behind{
        {1.0, 0.0, 0.0}, {0.0, -pane.wedge.cosine, pane.wedge.sine}, {0.0, -pane.wedge.sine, -pane.wedge.cosine}};
    add_face(parts, {-x, y, thick_z}, behind, width, height / pane.wedge.cosine, pane.back, parts.boundary(back));

    std::uint32_t const rim = parts.surface(parts.black(), parts.black());
    Shapes &shapes = parts.shapes();
    shapes.add(Parallelogram{{-x, -y, thin_z}, {width, 0.0, 0.0}, {0.0, 0.0, top_z - thin_z}, rim});
    shapes.add(Parallelogram{{-x, y, thick_z}, {width, 0.0, 0.0}, {0.0, 0.0, top_z - thick_z}, rim});
    for (double const side : {-x, x}) {
        Vector const front_low{side, -y, top_z};
        Vector const front_high{side, y, top_z};
        Vector const back_low{side, -y, thin_z};
        Vector const back_high{side, y, thick_z};
        shapes.add(Triangle{front_low, front_high, back_low, rim});
        shapes.add(Triangle{front_high, back_high, back_low, rim});
    }
}

} // namespace gonio::sim
