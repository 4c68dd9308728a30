// slat_stack.cpp: see slat_stack.hpp.
#include "slat_stack.hpp"

#include "elementary.hpp"
#include "shapes.hpp"

namespace gonio::sim {

namespace {

struct Slat {
    double shift; // along y
    double half_length;
    Shapes &shapes;

    void operator()(const Profile_line &line) const {
        shapes.add(Parallelogram{{-half_length, line.y0 + shift, line.z0},
                                 {2.0 * half_length, 0.0, 0.0},
                                 {0.0, line.y1 - line.y0, line.z1 - line.z0},
                                 line.surface});
    }
    void operator()(const Profile_arc &arc) const {
        auto const start = sine_cosine(arc.start_rad);
        shapes.add(Arc{{0.0, arc.y + shift, arc.z},
                       {1.0, 0.0, 0.0},
                       half_length,
                       arc.radius,
                       {0.0, start.cosine, start.sine},
                       arc.sweep_rad,
                       arc.surface});
    }
};

} // namespace

void add_slats(const Slat_stack &stack, Shapes &shapes) {
    for (std::uint32_t i = 0; i < stack.count; ++i) {
        Slat const slat{(static_cast<double>(stack.first) + i) * stack.pitch, stack.half_length, shapes};
        for (const Profile_piece &piece : stack.profile) {
            std::visit(slat, piece);
        }
    }
}

} // namespace gonio::sim
