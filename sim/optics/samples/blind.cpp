// blind.cpp: a Venetian blind of flat slats, alone or behind and before panes of glass (paper [0], section 2.7).
//
// Keys: depth_mm (10), pitch_mm (10), count (41), length_mm (400), offset_mm (0: the stack's shift along y), tilt_deg
// (0; positive lifts the inner edges), z_mm (0: where the outer edges lie), top and bottom (materials), and a list of
// panes: z_mm (of the front face), material, thickness_mm. Without thickness_mm a pane is a single sheet (`glass`,
// `thin-plate`), with it a solid body (`dielectric`) with black rims.
//
// Table 1: A top retro-reflective, bottom diffuse 0.8; B top specular 0.8, bottom diffuse 0.8; C both diffuse 0.8.
//
// Known answers: light at altitude theta in the plane phi = 90 passes directly by
// max(0, 1 - (depth / pitch) sin(theta + tilt) / cos(theta)); the cut-off is where that is 0, 45 degrees for the
// paper's blind; an ideal mirror on top, at tilt 0 and theta < 45, sends 0.8 (depth / pitch) tan(theta) upwards,
// altitude unchanged, and nothing else.
#include "kinds.hpp"
#include "pane.hpp"
#include "placing.hpp"
#include "slats.hpp"

namespace gonio::sim {
namespace {

constexpr double mm_of_panes = 400.0;

// What lies between two planes z = front and z = back, front above back.
struct Slab {
    double front_mm;
    double back_mm;
};

void refuse_overlap(const Toml_table &pane, const Slab &slab, const std::vector<Slab> &others) {
    for (const Slab &other : others) {
        bool const apart = slab.back_mm > other.front_mm || slab.front_mm < other.back_mm;
        if (!apart) {
            pane.fail("z_mm", "puts the pane into or onto the slats or another pane; move it");
        }
    }
}

} // namespace

void add_blind(Toml_table &table, Sample_parts &parts) {
    double const depth = positive(table, "depth_mm", 10.0);
    Stack const stack = read_stack(table, 10.0, 41);
    Sine_cosine const tilt = sine_cosine_of_deg(within(table, "tilt_deg", 0.0, -90.0, 90.0));
    double const z = table.number("z_mm", 0.0);
    const Material &top = parts.material(table, "top");
    const Material &bottom = parts.material(table, "bottom");
    Slat_surfaces const surfaces{parts.surface(top, bottom), parts.surface(bottom, top)};
    stack_slats(parts, {slat_section({0.0, z}, {depth * tilt.sine, z - depth * tilt.cosine}, 0.0, surfaces)}, stack);
    std::vector<Toml_table> panes = table.tables("panes");
    std::vector<Slab> taken = {{z, z - depth * tilt.cosine}};
    for (Toml_table &pane : panes) {
        double const pane_z = pane.number("z_mm");
        const Material &material = parts.material(pane, "material");
        bool const solid_body = pane.has("thickness_mm");
        double const thickness = solid_body ? positive(pane, "thickness_mm") : 0.0;
        Slab const slab{pane_z, pane_z - thickness};
        refuse_overlap(pane, slab, taken);
        taken.push_back(slab);
        if (solid_body) {
            Pane const solid{.size_mm = {mm_of_panes, mm_of_panes}, .front_z_mm = pane_z, .thickness_mm = thickness};
            add_pane(parts, solid, material, material);
        } else {
            parts.shapes().add(Parallelogram{{-0.5 * mm_of_panes, -0.5 * mm_of_panes, pane_z},
                                             {mm_of_panes, 0.0, 0.0},
                                             {0.0, mm_of_panes, 0.0},
                                             parts.surface(material, material)});
        }
        pane.finish();
    }
    if (!panes.empty()) {
        parts.model().slats.reset();
    }
}

} // namespace gonio::sim
