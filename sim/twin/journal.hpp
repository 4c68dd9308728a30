// journal.hpp: what a run leaves behind for tests and people, as one JSON object.
#pragma once

#include <filesystem>
#include <string>

#include "world.hpp"

namespace gonio::sim {

// A text in quotation marks, for JSON.
std::string json_text(const std::string &text);

// Written beside, then renamed. Throws Input_error when it cannot be written.
void write_journal(const std::filesystem::path &path, World &world, const std::string &end_reason, double wall_s);

} // namespace gonio::sim
