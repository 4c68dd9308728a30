// retro_beads.cpp: a retro-reflective coating of glass beads, sunk half into a layer that lines their lower halves.
//
// Keys: glass (a `dielectric`; index 1.9 to 2), cup (material that lines the sunk half: a mirror, or diffuse), binder
// (material between the beads), diameter_mm (0.5), pitch_mm (1.02 diameters; hexagonal), size_mm (80: of the round
// sample). The layer's shape is cups: what falls between two beads meets the outsides of their sunk halves, and a floor
// below them. The size of beads has no effect on the DSF as long as the beam covers many. Known answer: a ray that
// strikes a bead at angle i is turned by |2 i - 4 asin(sin(i) / n)| away from retro after one reflection (Born and
// Wolf, Principles of Optics, 4.6; the rainbow's ray): for n = 2 within 2.1 degrees for i <= 30 degrees, a quarter of
// each bead's area. Losses: two passages of the glass face and the cup's reflectance.
#include "kinds.hpp"

namespace gonio::sim {
namespace {

constexpr double half_root_three = 0.86602540378443864676;

} // namespace

void add_retro_beads(Toml_table &table, Sample_parts &parts) {
    const Material &glass = parts.material(table, "glass");
    const Material &cup = parts.material(table, "cup");
    const Material &binder = parts.material(table, "binder");
    double const diameter = positive(table, "diameter_mm", 0.5);
    double const pitch = positive(table, "pitch_mm", 1.02 * diameter);
    double const size = positive(table, "size_mm", 80.0);
    if (pitch <= diameter) {
        table.fail("pitch_mm", "must be above diameter_mm: beads must not touch");
    }
    double const reach = size / pitch;
    if (reach > 2000.0) {
        table.fail("size_mm", "makes more than 3 million beads; take fewer, larger ones: their size has no effect");
    }
    std::uint32_t const face = parts.boundary(glass);
    std::uint32_t const lining = parts.lining(binder, cup, glass.inside_absorption_per_mm());
    double const radius = 0.5 * diameter;
    Shapes &shapes = parts.shapes();
    auto const rows = static_cast<int>(0.5 * reach / half_root_three);
    auto const columns = static_cast<int>(0.5 * reach) + 1;
    for (int row = -rows; row <= rows; ++row) {
        double const y = row * half_root_three * pitch;
        double const shift = row % 2 == 0 ? 0.0 : 0.5;
        for (int column = -columns; column <= columns; ++column) {
            double const x = (column + shift) * pitch;
            if (x * x + y * y <= 0.25 * size * size) {
                Vector const centre{x, y, -radius};
                shapes.add(Sphere{centre, radius, face, {0.0, 0.0, 1.0}, 0.0});
                shapes.add(Sphere{centre, radius, lining, {0.0, 0.0, -1.0}, 0.0});
            }
        }
    }
    shapes.add(Disc{{0.0, 0.0, -diameter}, {0.0, 0.0, 1.0}, 0.0, 0.5 * size + radius, parts.surface(binder, binder)});
    parts.model().cell_width_mm = pitch;
    parts.model().cell_height_mm = 2.0 * half_root_three * pitch;
}

} // namespace gonio::sim
