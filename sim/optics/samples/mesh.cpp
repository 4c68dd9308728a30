// mesh.cpp: triangles from an OBJ file.
//
// Keys: file (beside the scenario), materials (the names that the file's `usemtl` gives, each also in [materials]; the
// first is taken for faces before any `usemtl`), unit_mm (1: length of the file's unit), position_mm ([0, 0, 0]: where
// its origin lies). Front is the side from which corners run counter-clockwise. A closed body of a `dielectric` has its
// front outside.
#include "kinds.hpp"
#include "obj.hpp"
#include "ray.hpp"

namespace gonio::sim {

void add_mesh(Toml_table &table, Sample_parts &parts) {
    std::string const file = table.text("file");
    std::vector<std::string> const names = table.texts("materials");
    if (names.empty()) {
        table.fail("materials", "must name at least one of [materials]");
    }
    double const unit = positive(table, "unit_mm", 1.0);
    auto const position = table.numbers<3>("position_mm", 0.0);
    Surface_names surfaces;
    for (const std::string &name : names) {
        std::uint32_t const surface = parts.boundary(parts.material_named(name, table, "materials"));
        surfaces.emplace("", surface);
        surfaces.emplace(name, surface);
    }
    Vector const origin{position[0], position[1], position[2]};
    Box box;
    for (Triangle triangle : read_obj(parts.context().folder / file, surfaces)) {
        for (Vector *corner : {&triangle.a, &triangle.b, &triangle.c}) {
            *corner = unit * *corner + origin;
            box.include(*corner);
        }
        parts.shapes().add(triangle);
    }
    if (parts.shapes().size() == 0) {
        table.fail("file", "has no faces");
    }
    parts.model().cell_width_mm = box.high.x - box.low.x;
    parts.model().cell_height_mm = box.high.y - box.low.y;
}

} // namespace gonio::sim
