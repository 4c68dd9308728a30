// beam_reader.cpp: the keys of [beam] and [source].
#include "beam_reader.hpp"

#include "elementary.hpp"
#include "sample_parts.hpp"

namespace gonio::sim {
namespace {

constexpr double rad_per_deg = elementary::pi / 180.0;

Stokes read_stokes(Toml_table &table) {
    if (table.has("polarisation_deg")) {
        if (table.has("stokes")) {
            table.fail("polarisation_deg", "and 'stokes' say the same thing; remove one");
        }
        return linear_polarisation(table.number("polarisation_deg"));
    }
    auto const [q, u, v] = table.numbers<3>("stokes", 0.0);
    return {q, u, v};
}

std::vector<Filament_bar> read_filament(std::vector<Toml_table> tables) {
    std::vector<Filament_bar> bars;
    for (Toml_table &table : tables) {
        Filament_bar bar{};
        bar.x_deg = table.number("x_deg", bar.x_deg);
        bar.y_deg = table.number("y_deg", bar.y_deg);
        bar.width_deg = table.number("width_deg");
        bar.height_deg = table.number("height_deg");
        bar.weight = table.number("weight", bar.weight);
        bar.gaussian = table.boolean("gaussian", bar.gaussian);
        table.finish();
        bars.push_back(bar);
    }
    return bars;
}

std::vector<Radial_row> read_radial(std::vector<Toml_table> tables) {
    std::vector<Radial_row> rows;
    for (Toml_table &table : tables) {
        rows.push_back({table.number("angle_deg"), table.number("relative")});
        table.finish();
    }
    return rows;
}

} // namespace

Source_settings read_beam(Toml_table beam, Toml_table source, double arm_radius_mm) {
    Source_settings settings{};
    std::string const kind = beam.text("kind", "collimated");
    if (kind != "collimated" && kind != "focused") {
        beam.fail("kind", "must be collimated or focused");
    }
    bool const collimated = kind == "collimated";
    settings.kind = collimated ? Beam_kind::collimated : Beam_kind::focused;
    settings.diameter_mm = positive(beam, "diameter_mm", collimated ? 65.0 : 10.0);
    if (settings.diameter_mm >= arm_radius_mm) {
        beam.fail("diameter_mm", "must be below the arm's radius");
    }
    double const edge_deg = within(beam, "edge_deg", 0.1, 0.0, 20.0);
    if (collimated) {
        if (beam.has("divergence_deg")) {
            beam.fail("divergence_deg", "is a focused beam's; a collimated one has [source] opening_angle_deg");
        }
        settings.opening_angle_deg = source.number("opening_angle_deg", settings.opening_angle_deg);
        settings.diameter_edge_mm = edge_deg * rad_per_deg * arm_radius_mm;
    } else {
        settings.opening_angle_deg = within(beam, "divergence_deg", 1.0, 0.01, 20.0);
        settings.edge_deg = edge_deg;
    }
    beam.ignore({"power_counts"}); // the closed forms' and the twin's
    beam.finish();
    settings.stop_distance_mm = positive(source, "stop_distance_mm", settings.stop_distance_mm);
    settings.lamp_distance_mm = source.number("lamp_distance_mm", settings.lamp_distance_mm);
    settings.radial = read_radial(source.tables("radial"));
    settings.filament = read_filament(source.tables("filament"));
    settings.stray_share = source.number("stray_share", settings.stray_share);
    settings.stray_half_angle_deg = source.number("stray_half_angle_deg", settings.stray_half_angle_deg);
    settings.stokes = read_stokes(source);
    source.finish();
    try {
        Beam_source const checked(settings);
    } catch (const Input_error &error) {
        throw Input_error(beam.where() + " and [source]: " + error.what());
    }
    return settings;
}

} // namespace gonio::sim
