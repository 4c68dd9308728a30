// material_reader.hpp: one [materials.NAME] table of a scenario file to a material, for one band. Keys: docs and
// material_reader.cpp, which holds one small function per kind.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "material.hpp"
#include "tabulated.hpp"
#include "toml_table.hpp"

namespace gonio::sim {

// What a material's values depend on, and where its data are. Keeps references.
struct Material_context {
    std::string band;                                   // picks from { visible = 0.8, near-infrared = 0.6 }
    double wavelength_nm;                               // where indices given as Cauchy's [A, B_um2] are taken
    const std::map<std::string, Scatter_table> &tables; // by the file name in the scenario
    std::filesystem::path folder;                       // where a text table that is not among them is looked for
};

// Refuses unknown keys, missing keys and values without physical sense. Throws Input_error.
std::unique_ptr<Material> read_material(Toml_table table, const Material_context &context);

// A value that may be given per band: a number, or a table with a number for each band that the scenario has. For the
// keys of samples too (the index of a pane).
double read_band_number(Toml_table &table, const std::string &key, const Material_context &context);
double read_band_number(Toml_table &table, const std::string &key, const Material_context &context, double fallback);
// An index of refraction: a number, per band, or Cauchy's [A, B_um2]: A + B / wavelength^2.
double read_index(Toml_table &table, const std::string &key, const Material_context &context, double fallback);

} // namespace gonio::sim
