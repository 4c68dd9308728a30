// weave.cpp: a basket-weave shade screen (paper [2]): pairs of threads that pass over and under one another.
//
// Keys: material (of the threads), pair_width_mm (0.58), thickness_mm (0.43: of the screen), pitch_mm (0.747: from pair
// to pair), size_mm (20: of the square of cloth), clearance_mm (0.001: between crossing pairs). A pair is one band with
// flat faces and round edges: coated threads side by side. Thickness of the screen is two bands and the clearance.
// Where it goes from over to under a band bends about the next band's edge at a constant distance, is straight, and
// bends back: cylinders and parts of tori, no facets. The published figures leave just enough room for it. Mind the
// openness: (1 - width / pitch)^2 is 5 % for a pitch of 0.747 mm. The paper takes 0.686 mm, which gives 2.4 %. Known
// answers: that openness at normal incidence; threads are opaque, so it is all that passes straight.
#include <cmath>

#include "kinds.hpp"
#include "placing.hpp"

namespace gonio::sim {
namespace {

// The cross-section of a band, and how far its middle lies from that of the screen.
struct Band_section {
    double half_flat; // of the flat faces' width
    double radius;    // of the edges: half the thickness
    double lift;      // of the middle line, over and under
};

// From over to under: an arc about the edge of the band that is crossed, a straight part, an arc back.
struct Bend {
    double run; // from edge middle to edge middle
    Sine_cosine angle;
    double angle_rad;
};

// Places on a band: u along it, w across the screen, from one crossing's middle on.
struct Band_place {
    double u;
    double w;
};

class Band_builder {
public:
    // `frame`: s along the band, t across it, n out of the screen.
    Band_builder(Shapes &shapes, std::uint32_t surface, const Band_section &section, const Vector &origin,
                 const Frame &frame)
        : shapes_(shapes), surface_(surface), section_(section), origin_(origin), frame_(frame) {}

    void straight(const Band_place &from, const Band_place &to) const {
        double const u = to.u - from.u;
        double const w = to.w - from.w;
        double const way = std::sqrt(u * u + w * w);
        Vector const along = frame_.to_world({u, 0.0, w});
        Vector const up = frame_.to_world({-w / way, 0.0, u / way});
        Vector const across = 2.0 * section_.half_flat * frame_.t;
        Vector const begin = at(from) - section_.half_flat * frame_.t;
        shapes_.add(Parallelogram{begin + section_.radius * up, along, across, surface_});
        shapes_.add(Parallelogram{begin - section_.radius * up, across, along, surface_});
        for (double const side : {-1.0, 1.0}) {
            Vector const middle = at(from) + 0.5 * along + side * section_.half_flat * frame_.t;
            shapes_.add(
                Arc{middle, (1.0 / way) * along, 0.5 * way, section_.radius, -side * up, elementary::pi, surface_});
        }
    }

    // About `axis`; `start` from it in (u, w), turning from w towards u.
    void bend(const Band_place &axis, const Band_place &start, double sweep_rad) const {
        Vector const begin = frame_.to_world({start.u, 0.0, start.w});
        double const radius = 2.0 * section_.lift;
        for (double const face : {radius + section_.radius, radius - section_.radius}) {
            shapes_.add(Arc{at(axis), frame_.t, section_.half_flat, face, begin, sweep_rad, surface_});
        }
        for (double const side : {-1.0, 1.0}) {
            shapes_.add(Torus_arc{at(axis) + side * section_.half_flat * frame_.t, frame_.t, begin, sweep_rad, radius,
                                  section_.radius, surface_});
        }
    }

    // Over the crossing at u and, if another follows, on to it; `over` is 1 or -1.
    void crossing(double u, double over) const {
        straight({u - section_.half_flat, over * section_.lift}, {u + section_.half_flat, over * section_.lift});
    }
    void descend(double u, double over, const Bend &bend_to) const {
        double const lift = over * section_.lift;
        auto const [sine, cosine] = bend_to.angle;
        Band_place const first{u + section_.half_flat, -lift};
        Band_place const second{first.u + bend_to.run, lift};
        double const radius = 2.0 * lift;
        // About the first edge from over it, forwards; about the second to below it. Rising, all is upside down.
        if (over > 0.0) {
            bend(first, {0.0, 1.0}, bend_to.angle_rad);
            bend(second, {0.0, -1.0}, bend_to.angle_rad);
        } else {
            bend(first, {sine, -cosine}, bend_to.angle_rad);
            bend(second, {-sine, cosine}, bend_to.angle_rad);
        }
        double const reach = 2.0 * section_.lift * sine;
        straight({first.u + reach, first.w + radius * cosine}, {second.u - reach, second.w - radius * cosine});
    }

private:
    [[nodiscard]] Vector at(const Band_place &place) const {
        return origin_ + frame_.to_world({place.u, 0.0, place.w});
    }

    Shapes &shapes_;
    std::uint32_t surface_;
    const Band_section &section_;
    Vector origin_;
    Frame frame_;
};

// The slope on which a straight part touches both arcs, of radius 2 lift, whose middles are `run` and 2 lift apart.
Bend bend_of(double run, double lift) {
    double const between = 4.0 * lift;
    double const straight = std::sqrt(run * run + between * (0.25 * between) - between * between);
    double const angle_rad = arc_tangent(between, straight) - arc_tangent(2.0 * lift, run);
    return {run, sine_cosine(angle_rad), angle_rad};
}

} // namespace

void add_weave(Toml_table &table, Sample_parts &parts) {
    const Material &material = parts.material(table, "material");
    double const width = positive(table, "pair_width_mm", 0.58);
    double const thickness = positive(table, "thickness_mm", 0.43);
    double const pitch = positive(table, "pitch_mm", 0.747);
    double const size = positive(table, "size_mm", 20.0);
    double const clearance = positive(table, "clearance_mm", 0.001);
    Band_section section{};
    section.radius = 0.25 * (thickness - clearance);
    section.lift = section.radius + 0.5 * clearance;
    section.half_flat = 0.5 * width - section.radius;
    if (section.radius <= 0.0 || section.half_flat <= 0.0) {
        table.fail("pair_width_mm", "must be above half of thickness_mm: a pair is wider than it is thick");
    }
    double const run = pitch - 2.0 * section.half_flat;
    // The straight part's length must not vanish: run^2 > 12 lift^2.
    double const least_run = 2.0 * 1.7320508075688773 * section.lift;
    if (run < least_run) {
        table.fail("pitch_mm", "must be at least " + std::to_string(2.0 * section.half_flat + least_run) +
                                   ": the pairs have no room to bend about each other");
    }
    if (size / pitch > 1000.0) {
        table.fail("size_mm", "makes more than 16 million primitives");
    }
    Bend const bend = bend_of(run, section.lift);
    std::uint32_t const surface = parts.surface(material, material);
    auto const most = static_cast<int>(0.5 * size / pitch);
    double const middle_z = -section.lift - section.radius;
    Frame const weft{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    Frame const warp{{0.0, 1.0, 0.0}, {-1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}};
    for (int number = -most; number <= most; ++number) {
        Band_builder const along_x(parts.shapes(), surface, section, {0.0, number * pitch, middle_z}, weft);
        Band_builder const along_y(parts.shapes(), surface, section, {number * pitch, 0.0, middle_z}, warp);
        for (int crossed = -most; crossed <= most; ++crossed) {
            double const over = (number + crossed) % 2 == 0 ? 1.0 : -1.0;
            along_x.crossing(crossed * pitch, over);
            along_y.crossing(crossed * pitch, -over);
            if (crossed < most) {
                along_x.descend(crossed * pitch, over, bend);
                along_y.descend(crossed * pitch, -over, bend);
            }
        }
    }
    parts.model().cell_width_mm = 2.0 * pitch;
    parts.model().cell_height_mm = 2.0 * pitch;
}

} // namespace gonio::sim
