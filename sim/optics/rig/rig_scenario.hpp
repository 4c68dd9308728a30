// rig_scenario.hpp: a photon-map scenario file with all of its [rig]: what twin, module and benchmarks load.
#pragma once

#include "photon_scenario.hpp"

namespace gonio::sim {

// As load_photon_scenario(), and what stands around the sample. Keys of [rig] beside the sample's `holder`:
// `splitters`, a table of sample_distance_mm (105), side_mm (100), baffle (true) and plate, a material
// ({ kind = "thin-plate", reflectance_s, ... }). Throws Input_error.
Photon_scenario load_rig_scenario(const std::filesystem::path &path, const std::filesystem::path &source_directory,
                                  const std::map<std::string, Scatter_table> &tables);

} // namespace gonio::sim
