// module_parts.hpp: what the files of the Python module share.
#pragma once

#include <string>

#include <nanobind/nanobind.h>

#include "photon_scenario.hpp"

namespace gonio::sim {

// Throws Input_error.
const Band &band_of(const Photon_scenario &scenario, const std::string &name);
nanobind::dict as_dict(const Balance &balance);
void bind_patches(nanobind::module_ &module);

} // namespace gonio::sim
