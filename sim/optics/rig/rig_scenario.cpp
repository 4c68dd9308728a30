// rig_scenario.cpp: reads what a scenario file has under [rig] besides the sample's holder.
#include "rig_scenario.hpp"

#include <memory>

#include "material_reader.hpp"
#include "sample_parts.hpp"
#include "splitter_rig.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

// The file as it is kept for making the plates anew.
struct Document {
    toml::table root;
    std::map<std::string, Scatter_table> tables;
    std::filesystem::path path;

    [[nodiscard]] Toml_table splitters() const {
        Toml_table file(root, path.string());
        Toml_table rig = file.table("rig");
        return rig.table("splitters");
    }
    [[nodiscard]] std::unique_ptr<Material> plate(const Band &band) const {
        Material_context const context{band.name, band.wavelength_nm, tables, path.parent_path()};
        return read_material(splitters().table("plate"), context);
    }
};

Splitter_rig read_splitters(Toml_table table) {
    Splitter_rig rig;
    rig.sample_distance_mm = positive(table, "sample_distance_mm", rig.sample_distance_mm);
    rig.side_mm = positive(table, "side_mm", rig.side_mm);
    rig.baffle = table.boolean("baffle", rig.baffle);
    if (!(rig.sample_distance_mm > splitter_depth_mm(rig))) {
        table.fail("sample_distance_mm", "must be above side_mm / sqrt(8): the splitters stand before the sample");
    }
    table.ignore({"plate"});
    table.finish();
    return rig;
}

} // namespace

Photon_scenario load_rig_scenario(const std::filesystem::path &path, const std::filesystem::path &source_directory,
                                  const std::map<std::string, Scatter_table> &tables) {
    Photon_scenario scenario = load_photon_scenario(path, source_directory, tables);
    auto const document = std::make_shared<const Document>(Document{parse_toml_file(path), tables, path});
    Toml_table file(document->root, path.string());
    Toml_table rig = file.table("rig");
    rig.ignore({"holder", "splitters"});
    rig.finish();
    if (rig.has("splitters")) {
        Splitter_rig const splitters = read_splitters(document->splitters());
        if (splitters.sample_distance_mm >= scenario.receiver.radius_mm) {
            document->splitters().fail("sample_distance_mm", "must be below the arm's radius");
        }
        surround_with_splitters(scenario, splitters, [document](const Band &band) { return document->plate(band); });
        for (const Band &band : scenario.bands) {
            scenario.sample(band, false); // says now what is wrong with the plate
        }
    }
    return scenario;
}

} // namespace gonio::sim
