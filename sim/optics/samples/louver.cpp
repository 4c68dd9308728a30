// louver.cpp: light-redirecting louver with slats of two sections, after RETROLuxTherm 12 mm (papers [1] and [4]).
//
// Keys: chord_mm (12), pitch_mm (10), count (39), length_mm (400), offset_mm (0), inclination_deg (7: of the chord by
// design, positive lifts the inner edge), tilt_deg (0: error of it, the same sense), shelf_sagitta_mm (1) of the outer
// section, retro_sagitta_mm (2) of the inner one, apex_fraction (0.5: where along the chord the two meet),
// apex_offset_mm (0: how far the apex lies above the chord), top and bottom (materials).
//
// What the papers say: slats 12 mm deep, 10 mm apart, 39 of them; an outer section that is a light shelf and an inner
// one that returns light from above 35 degrees; ends and apex collinear by design, not so in production; production
// tilted by 4 degrees; top an aluminium mirror, bottom glossy white paint. The profile itself is not published. It is
// reconstructed here as two circular arcs that sag below the chord. The chord's inclination follows from paper [1]
// Table 3: 1 - (chord / pitch) sin(theta + inclination) / cos(theta) is 0.166 and 0.020 at 30 and 35 degrees for 7
// degrees (printed for V2: 0.172, 0.010), 0.245 and 0.098 for 3 degrees (V3: 0.272, 0.109). The sagittas are round
// figures with which the total transmittance falls from 30 to 35 degrees and rises after, as in Table 2. Known answers:
// that formula, and its zero, the cut-off: 35.6 degrees for V2.
#include "kinds.hpp"
#include "placing.hpp"
#include "slats.hpp"

namespace gonio::sim {

void add_louver(Toml_table &table, Sample_parts &parts) {
    double const chord = positive(table, "chord_mm", 12.0);
    Stack const stack = read_stack(table, 10.0, 39);
    double const inclination_deg =
        within(table, "inclination_deg", 7.0, -45.0, 45.0) + within(table, "tilt_deg", 0.0, -45.0, 45.0);
    double const apex_fraction = within(table, "apex_fraction", 0.5, 0.05, 0.95);
    double const apex_offset = table.number("apex_offset_mm", 0.0);
    double const shelf_sagitta = table.number("shelf_sagitta_mm", 1.0);
    double const retro_sagitta = table.number("retro_sagitta_mm", 2.0);
    const Material &top = parts.material(table, "top");
    const Material &bottom = parts.material(table, "bottom");

    // From the outer edge at the origin: inwards along the chord, and up from it.
    Sine_cosine const inclination = sine_cosine_of_deg(inclination_deg);
    auto const at = [&](double along, double above) {
        return Profile_point{along * inclination.sine + above * inclination.cosine,
                             above * inclination.sine - along * inclination.cosine};
    };
    Profile_point const apex = at(apex_fraction * chord, apex_offset);
    Slat_surfaces const surfaces{parts.surface(top, bottom), parts.surface(bottom, top)};
    stack_slats(parts,
                {slat_section({0.0, 0.0}, apex, shelf_sagitta, surfaces),
                 slat_section(apex, at(chord, 0.0), retro_sagitta, surfaces)},
                stack);
}

} // namespace gonio::sim
