// slats.cpp: a stack of equal slats.
#include "slats.hpp"

#include <cmath>

#include "placing.hpp"

namespace gonio::sim {
Stack read_stack(Toml_table &table, double pitch_mm, std::uint32_t count) {
    Stack stack{};
    stack.pitch_mm = positive(table, "pitch_mm", pitch_mm);
    stack.offset_mm = table.number("offset_mm", 0.0);
    stack.length_mm = positive(table, "length_mm", 400.0);
    std::int64_t const slats = table.integer("count", count);
    if (slats < 1 || slats > 100000) {
        table.fail("count", "must be from 1 to 100000");
    }
    stack.count = static_cast<std::uint32_t>(slats);
    return stack;
}

void stack_slats(Sample_parts &parts, const std::vector<Profile_piece> &profile, const Stack &stack) {
    // Of an even number the lower half has one more: the middle is shifted by half a pitch.
    std::int32_t const first = -static_cast<std::int32_t>(stack.count / 2);
    double const middle = stack.offset_mm + (stack.count % 2 == 0 ? 0.5 * stack.pitch_mm : 0.0);
    std::vector<Profile_piece> placed = profile;
    for (Profile_piece &piece : placed) {
        if (auto *line = std::get_if<Profile_line>(&piece); line != nullptr) {
            line->y0 += middle;
            line->y1 += middle;
        } else {
            std::get<Profile_arc>(piece).y += middle;
        }
    }
    Sample_model &model = parts.model();
    model.slats = Slat_stack{std::move(placed), stack.pitch_mm, first, stack.count, 0.5 * stack.length_mm};
    add_slats(*model.slats, model.shapes);
    model.cell_width_mm = stack.pitch_mm;
    model.cell_height_mm = stack.pitch_mm;
}

Profile_piece slat_section(const Profile_point &outer, const Profile_point &inner, double sagitta_mm,
                           const Slat_surfaces &surfaces) {
    if (sagitta_mm == 0.0) {
        return Profile_line{outer.y, outer.z, inner.y, inner.z, surfaces.top_in_front};
    }
    double const y = inner.y - outer.y;
    double const z = inner.z - outer.z;
    double const chord = std::sqrt(y * y + z * z);
    double const sagitta = std::abs(sagitta_mm);
    double const radius = (0.25 * chord * chord + sagitta * sagitta) / (2.0 * sagitta);
    // From the chord's middle to the axis: upwards for a section that sags. Upwards is to the left of the way inwards.
    bool const sags = sagitta_mm > 0.0;
    double const to_axis = (sags ? radius - sagitta : sagitta - radius) / chord;
    double const axis_y = 0.5 * (outer.y + inner.y) - to_axis * z;
    double const axis_z = 0.5 * (outer.z + inner.z) + to_axis * y;
    const Profile_point &begin = sags ? outer : inner;
    return Profile_arc{axis_y,
                       axis_z,
                       radius,
                       arc_tangent(begin.z - axis_z, begin.y - axis_y),
                       2.0 * arc_tangent(0.5 * chord, radius - sagitta),
                       sags ? surfaces.bottom_in_front : surfaces.top_in_front};
}

} // namespace gonio::sim
