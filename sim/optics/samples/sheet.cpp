// sheet.cpp: a flat sheet at z = 0: kinds `lambertian`, `mirror` and `sheet`.
//
// Keys of all: shape = "disc" | "rectangle"; size_mm = diameter, or [width, height].
// `lambertian`: reflectance, transmittance (default 0); `mirror`: reflectance; both may be given per band.
// `sheet`: material, and back if the other side has another.
// Known answers: Lambertian DSF = reflectance cos(theta) / pi towards +z at any incidence; a mirror returns
// `reflectance` about (theta_i, phi_i + 180), as wide as the beam; a thin plate's sums are Fresnel's (Hecht, Optics,
// ch. 4 and 9).
#include "kinds.hpp"
#include "lambertian.hpp"
#include "mirror.hpp"

namespace gonio::sim {
namespace {

void add_flat(Toml_table &table, Sample_parts &parts, std::uint32_t surface) {
    std::string const shape = table.text("shape", "disc");
    if (shape != "disc" && shape != "rectangle") {
        table.fail("shape", "must be disc or rectangle");
    }
    auto const size_mm = table.numbers<2>("size_mm", 400.0);
    if (!(size_mm[0] > 0.0 && size_mm[1] > 0.0)) {
        table.fail("size_mm", "must be above 0");
    }
    if (shape == "disc") {
        if (size_mm[0] != size_mm[1]) {
            table.fail("size_mm", "must be one number, the diameter, for a disc");
        }
        parts.shapes().add(Disc{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 0.0, 0.5 * size_mm[0], surface});
        return;
    }
    parts.shapes().add(Parallelogram{
        {-0.5 * size_mm[0], -0.5 * size_mm[1], 0.0}, {size_mm[0], 0.0, 0.0}, {0.0, size_mm[1], 0.0}, surface});
}

double power(Toml_table &table, const std::string &key, double value) {
    if (!(value >= 0.0 && value <= 1.0)) {
        table.fail(key, "must be from 0 to 1");
    }
    return value;
}

} // namespace

void add_lambertian(Toml_table &table, Sample_parts &parts) {
    double const reflectance = power(table, "reflectance", read_band_number(table, "reflectance", parts.context()));
    double const transmittance =
        power(table, "transmittance", read_band_number(table, "transmittance", parts.context(), 0.0));
    power(table, "reflectance", reflectance + transmittance);
    const Material &material = parts.own(std::make_unique<Lambertian>(reflectance, transmittance));
    add_flat(table, parts, parts.surface(material, material));
}

void add_mirror(Toml_table &table, Sample_parts &parts) {
    double const reflectance = power(table, "reflectance", read_band_number(table, "reflectance", parts.context()));
    const Material &material = parts.own(std::make_unique<Mirror>(reflectance));
    add_flat(table, parts, parts.surface(material, material));
}

void add_sheet(Toml_table &table, Sample_parts &parts) {
    const Material &front = parts.material(table, "material");
    const Material &back = table.has("back") ? parts.material(table, "back") : front;
    add_flat(table, parts, parts.surface(front, back));
}

} // namespace gonio::sim
