// personality.hpp: the three sorts of drive, each an EDS in protocol/eds; what is missing there is refused.
#pragma once

#include <filesystem>
#include <string>

#include "eds.hpp"

namespace gonio::sim {

// full:  every object that the firmware asks for;
// basic: no 0x6007, no 0x1029, interpolation period (0x60C2) read-only at 2 ms;
// fixed: constant PDO mapping, following error window (0x6065) off after power-up.
// Throws std::runtime_error naming the three, or what is wrong with the file.
Eds_file load_personality(const std::string &name, const std::filesystem::path &eds_directory);

} // namespace gonio::sim
