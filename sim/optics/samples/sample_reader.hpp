// sample_reader.hpp: a scenario's [sample], [materials] and [rig] holder to shapes and materials, for one band.
#pragma once

#include "material_reader.hpp"
#include "sample.hpp"
#include "toml_table.hpp"

namespace gonio::sim {

// Strict: unknown keys, materials that nothing names and values without sense throw Input_error. `rig` may hold a
// `holder`; its other keys are not looked at.
Sample_model read_sample(const toml::table &scenario, const std::string &where, const Material_context &context);

// Nothing in the beam: the free beam is measured before the sample moves in with its holder.
Sample_model free_beam();

} // namespace gonio::sim
