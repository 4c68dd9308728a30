// kinds.hpp: the kinds of sample, one file each. Keys and known answers stand at the top of the file of the kind.
#pragma once

#include "sample_parts.hpp"

namespace gonio::sim {

void add_lambertian(Toml_table &table, Sample_parts &parts);
void add_mirror(Toml_table &table, Sample_parts &parts);
void add_sheet(Toml_table &table, Sample_parts &parts);
void add_blind(Toml_table &table, Sample_parts &parts);
void add_louver(Toml_table &table, Sample_parts &parts);
void add_weave(Toml_table &table, Sample_parts &parts);
void add_window_glass(Toml_table &table, Sample_parts &parts);
void add_retro_beads(Toml_table &table, Sample_parts &parts);
void add_retro_cubes(Toml_table &table, Sample_parts &parts);
void add_mesh(Toml_table &table, Sample_parts &parts);

} // namespace gonio::sim
