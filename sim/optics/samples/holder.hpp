// holder.hpp: what holds a sample: a round plate with a round opening (paper [3]: plates cut to fit the finds).
#pragma once

#include "sample_parts.hpp"

namespace gonio::sim {

// Keys: opening_mm, thickness_mm (5), size_mm (200: diameter), reflectance (0.05, diffuse, also per band), z_mm (its
// front face; default: thickness_mm, the plate lies on the sample's front).
void add_holder(Toml_table &table, Sample_parts &parts);

} // namespace gonio::sim
