// holder.cpp: a round plate with an opening.
#include "holder.hpp"

#include "lambertian.hpp"
#include "placing.hpp"

namespace gonio::sim {

void add_holder(Toml_table &table, Sample_parts &parts) {
    double const opening = positive(table, "opening_mm");
    double const thickness = positive(table, "thickness_mm", 5.0);
    double const size = positive(table, "size_mm", 200.0);
    double const front_z = table.number("z_mm", thickness);
    if (size <= opening) {
        table.fail("size_mm", "must be above opening_mm");
    }
    double const reflectance = read_band_number(table, "reflectance", parts.context(), 0.05);
    if (!(reflectance >= 0.0 && reflectance <= 1.0)) {
        table.fail("reflectance", "must be from 0 to 1");
    }
    table.finish();
    const Material &finish = parts.own(std::make_unique<Lambertian>(reflectance));
    std::uint32_t const surface = parts.surface(finish, finish);
    Shapes &shapes = parts.shapes();
    Vector const outwards{0.0, 0.0, 1.0};
    for (double const z : {front_z, front_z - thickness}) {
        shapes.add(Disc{{0.0, 0.0, z}, outwards, 0.5 * opening, 0.5 * size, surface});
    }
    for (double const diameter : {opening, size}) {
        shapes.add(Arc{{0.0, 0.0, front_z - 0.5 * thickness},
                       outwards,
                       0.5 * thickness,
                       0.5 * diameter,
                       {1.0, 0.0, 0.0},
                       2.0 * elementary::pi,
                       surface});
    }
    parts.model().slats.reset();
}

} // namespace gonio::sim
