// photon_map.hpp: the optics of a photon-map scenario, for a program that knows nothing else of the photon map.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "optics.hpp"

namespace gonio::sim {

struct Photon_map_request {
    std::filesystem::path scenario;
    std::filesystem::path source_directory;
    std::string band; // what the detector sees; empty: the file's first
    double memory_mib;
    double incident_tolerance_deg;
    bool prepare; // trace the free beam and the directions that the file names at once, so that nobody waits later
};

// Takes the file's photon number and all processors. `say` hears a line before and after each map is traced. Throws
// Input_error on what is wrong in the file, if it has no such band, and if one map may pass the memory.
std::unique_ptr<Optics> photon_map_optics(const Photon_map_request &request,
                                          const std::function<void(const std::string &)> &say);

} // namespace gonio::sim
