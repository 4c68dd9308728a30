// beam_reader.hpp: a scenario's [beam] and [source] to the settings of the illuminator.
#pragma once

#include "beam_source.hpp"
#include "toml_table.hpp"

namespace gonio::sim {

// [beam] is shared with the closed forms: a collimated beam's edge_deg is seen from the detector. Throws Input_error.
Source_settings read_beam(Toml_table beam, Toml_table source, double arm_radius_mm);

} // namespace gonio::sim
