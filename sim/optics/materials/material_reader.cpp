// material_reader.cpp: the keys of each kind of material.
#include "material_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "black.hpp"
#include "dielectric.hpp"
#include "elementary.hpp"
#include "ggx_dielectric.hpp"
#include "lambertian.hpp"
#include "layers.hpp"
#include "mirror.hpp"
#include "radiance_finish.hpp"
#include "thin_plate.hpp"
#include "ward_duer.hpp"

namespace gonio::sim {
namespace {

using Owned = std::unique_ptr<Material>;
using Context = const Material_context &;

constexpr double rounding = 1e-9; // of sums of decimal fractions

double within(const Toml_table &table, const std::string &key, double value, double least, double most,
              const std::string &what) {
    if (!(value >= least && value <= most)) {
        table.fail(key, "must be " + what);
    }
    return value;
}

double share(Toml_table &table, const std::string &key, Context context, std::optional<double> fallback = {}) {
    double const value =
        fallback ? read_band_number(table, key, context, *fallback) : read_band_number(table, key, context);
    return within(table, key, value, 0.0, 1.0, "from 0 to 1");
}

double not_negative(Toml_table &table, const std::string &key, Context context, double fallback) {
    return within(table, key, read_band_number(table, key, context, fallback), 0.0, 1e9, "0 or more");
}

double roughness(Toml_table &table, const std::string &key, Context context, double fallback) {
    return within(table, key, read_band_number(table, key, context, fallback), 0.0, 2.0, "from 0 to 2");
}

// Also as Radiance gives it: what remains of the light after 1 mm.
double absorption_per_mm(Toml_table &table, Context context) {
    if (!table.has("transmission_per_mm")) {
        return not_negative(table, "absorption_per_mm", context, 0.0);
    }
    if (table.has("absorption_per_mm")) {
        table.fail("transmission_per_mm", "is the same as absorption_per_mm in other words; remove one");
    }
    double const remains = share(table, "transmission_per_mm", context);
    return -logarithm(within(table, "transmission_per_mm", remains, 1e-300, 1.0, "above 0"));
}

void need_sum_below_one(const Toml_table &table, const std::string &key, double sum) {
    if (sum > 1.0 + rounding) {
        table.fail(key, "and what goes with it add up to more than 1; lower one of them");
    }
}

Owned lambertian(Toml_table &table, Context context) {
    double const reflectance = share(table, "reflectance", context, 0.0);
    double const transmittance = share(table, "transmittance", context, 0.0);
    if (!table.has("reflectance") && !table.has("transmittance")) {
        table.fail("reflectance", "is missing");
    }
    need_sum_below_one(table, "reflectance", reflectance + transmittance);
    return std::make_unique<Lambertian>(reflectance, transmittance);
}

Owned mirror(Toml_table &table, Context context) {
    if (table.has("reflectance")) {
        return std::make_unique<Mirror>(share(table, "reflectance", context));
    }
    double const s = share(table, "reflectance_s", context);
    return std::make_unique<Mirror>(s, share(table, "reflectance_p", context));
}

Owned metal(Toml_table &table, Context context) {
    double const colour = share(table, "reflectance", context);
    double const specularity = share(table, "specularity", context);
    return radiance_metal(colour, specularity, roughness(table, "roughness", context, 0.0));
}

Owned plastic(Toml_table &table, Context context) {
    double const colour = share(table, "reflectance", context);
    double const specularity = share(table, "specularity", context);
    return radiance_plastic(colour, specularity, roughness(table, "roughness", context, 0.0));
}

Owned ward_duer(Toml_table &table, Context context) {
    double const reflectance = share(table, "reflectance", context);
    double const specular = share(table, "specular_share", context);
    double const x = roughness(table, "roughness_x", context, 0.0);
    double const y = roughness(table, "roughness_y", context, x);
    if ((x > 0.0) != (y > 0.0)) {
        table.fail("roughness_y", "and roughness_x must both be 0 (an ideal mirror part) or both above 0");
    }
    return std::make_unique<Ward_duer>(reflectance, specular, x, y);
}

Owned glass(Toml_table &table, Context context) {
    double const transmissivity = share(table, "transmissivity", context);
    return std::make_unique<Thin_plate>(glass_plate(transmissivity, read_index(table, "index", context, 1.52)));
}

Owned dielectric(Toml_table &table, Context context) {
    double const index = read_index(table, "index", context, 1.52);
    double const outside = read_index(table, "outside_index", context, 1.0);
    return std::make_unique<Dielectric>(index, outside, absorption_per_mm(table, context));
}

Owned ggx_dielectric(Toml_table &table, Context context) {
    double const index = read_index(table, "index", context, 1.52);
    double const outside = read_index(table, "outside_index", context, 1.0);
    double const absorption = absorption_per_mm(table, context);
    double const x = within(table, "alpha_x", read_band_number(table, "alpha_x", context), 0.0, 2.0, "from 0 to 2");
    double const y = within(table, "alpha_y", read_band_number(table, "alpha_y", context, x), 0.0, 2.0, "from 0 to 2");
    if (x == 0.0 && y == 0.0) {
        return std::make_unique<Dielectric>(index, outside, absorption);
    }
    if (x < 1e-4 || y < 1e-4) {
        table.fail("alpha_x", "and alpha_y must both be 0 (smooth) or both at least 0.0001");
    }
    if (std::abs(index / outside - 1.0) < 1e-6) {
        table.fail("index", "is that of the outside: such a boundary does nothing; leave it away");
    }
    return std::make_unique<Ggx_dielectric>(x, y, index, outside, absorption);
}

Plate plate(Toml_table &table, Context context) {
    double const index = read_index(table, "index", context, 1.52);
    double const absorption = absorption_per_mm(table, context);
    double const thickness_mm = not_negative(table, "thickness_mm", context, 0.0);
    if (absorption > 0.0 && !table.has("thickness_mm")) {
        table.fail("thickness_mm", "is missing, which the absorption needs");
    }
    return {index, absorption * thickness_mm};
}

Owned thin_plate(Toml_table &table, Context context) {
    if (!table.has("reflectance_s")) {
        return std::make_unique<Thin_plate>(plate(table, context));
    }
    double const reflectance_s = share(table, "reflectance_s", context);
    double const reflectance_p = share(table, "reflectance_p", context);
    double const transmittance_s = share(table, "transmittance_s", context);
    double const transmittance_p = share(table, "transmittance_p", context);
    need_sum_below_one(table, "reflectance_s", reflectance_s + transmittance_s);
    need_sum_below_one(table, "reflectance_p", reflectance_p + transmittance_p);
    return std::make_unique<Splitter>(reflectance_s, reflectance_p, transmittance_s, transmittance_p);
}

// A value for s and p, or one each.
std::array<double, 2> both(Toml_table &table, const std::string &key, Context context, std::optional<double> fallback) {
    if (table.has(key + "_s") || table.has(key + "_p")) {
        double const s = share(table, key + "_s", context);
        return {s, share(table, key + "_p", context)};
    }
    double const value = share(table, key, context, fallback);
    return {value, value};
}

Coating coating(Toml_table &table, Context context) {
    auto const [front_s, front_p] = both(table, "reflectance", context, {});
    bool const sides = table.has("back_reflectance") || table.has("back_reflectance_s");
    auto const [back_s, back_p] =
        sides ? both(table, "back_reflectance", context, {}) : std::array<double, 2>{front_s, front_p};
    auto const [through_s, through_p] = both(table, "transmittance", context, 0.0);
    need_sum_below_one(table, "transmittance", std::max(front_s, back_s) + through_s);
    need_sum_below_one(table, "transmittance", std::max(front_p, back_p) + through_p);
    return {front_s, front_p, back_s, back_p, through_s, through_p};
}

Owned layers(Toml_table &table, Context context) {
    std::vector<Layers::Layer> stack;
    for (Toml_table &layer : table.tables("layer")) {
        std::string const kind = layer.text("kind");
        if (kind == "plate") {
            stack.emplace_back(plate(layer, context));
        } else if (kind == "glass") {
            double const transmissivity = share(layer, "transmissivity", context);
            stack.emplace_back(glass_plate(transmissivity, read_index(layer, "index", context, 1.52)));
        } else if (kind == "coating") {
            stack.emplace_back(coating(layer, context));
        } else {
            layer.fail("kind", "of a layer is plate, glass or coating");
        }
        layer.finish();
    }
    if (stack.empty()) {
        table.fail("layer", "is missing: give at least one [[...layer]], front first");
    }
    return std::make_unique<Layers>(std::move(stack));
}

Owned tabulated(Toml_table &table, Context context) {
    std::string const file = table.text("file");
    std::string const name = table.where() + ": " + file;
    auto const known = context.tables.find(file);
    if (known != context.tables.end()) {
        table.ignore({"follow"}); // who read the file has put it into the table
        return std::make_unique<Tabulated>(known->second, name);
    }
    return std::make_unique<Tabulated>(load_scatter_table(context.folder / file), name);
}

} // namespace

double read_band_number(Toml_table &table, const std::string &key, const Material_context &context) {
    if (!table.is_table(key)) {
        return table.number(key);
    }
    Toml_table bands = table.table(key);
    if (!bands.has(context.band)) {
        bands.fail(context.band, "is missing: a band of the scenario");
    }
    return bands.number(context.band); // the other bands' numbers are for other runs
}

double read_band_number(Toml_table &table, const std::string &key, const Material_context &context, double fallback) {
    return table.has(key) ? read_band_number(table, key, context) : fallback;
}

double read_index(Toml_table &table, const std::string &key, const Material_context &context, double fallback) {
    double value = 0.0;
    if (table.is_list(key)) {
        auto const [a, b_um2] = table.numbers<2>(key, 0.0);
        double const wavelength_um = 1e-3 * context.wavelength_nm;
        value = a + b_um2 / (wavelength_um * wavelength_um);
    } else {
        value = read_band_number(table, key, context, fallback);
    }
    return within(table, key, value, 0.1, 10.0, "an index of refraction, from 0.1 to 10");
}

std::unique_ptr<Material> read_material(Toml_table table, const Material_context &context) {
    struct Kind {
        const char *name;
        Owned (*read)(Toml_table &, Context);
    };
    constexpr std::array<Kind, 12> kinds{{
        {"black", [](Toml_table &, Context) -> Owned { return std::make_unique<Black>(); }},
        {"lambertian", lambertian},
        {"mirror", mirror},
        {"metal", metal},
        {"plastic", plastic},
        {"glass", glass},
        {"dielectric", dielectric},
        {"ward-duer", ward_duer},
        {"ggx-dielectric", ggx_dielectric},
        {"thin-plate", thin_plate},
        {"layers", layers},
        {"tabulated", tabulated},
    }};
    std::string const kind = table.text("kind");
    std::string names;
    for (const Kind &known : kinds) {
        if (kind == known.name) {
            Owned material = known.read(table, context);
            table.finish();
            return material;
        }
        names += (names.empty() ? "" : ", ") + std::string(known.name);
    }
    table.fail("kind", "is '" + kind + "'; known are " + names);
}

} // namespace gonio::sim
