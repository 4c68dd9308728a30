// journal.hpp: what a run leaves behind for tests and people, as one JSON object.
#pragma once

#include <filesystem>
#include <string>

#include "world.hpp"

namespace gonio::sim {

// Members of a JSON object, without its braces: how the apparatus is and what happened to it.
std::string apparatus_members(const Apparatus &apparatus);

// A text in quotation marks, for JSON.
std::string json_text(const std::string &text);

// Written beside, then renamed. Throws Input_error when it cannot be written.
void write_journal(const std::filesystem::path &path, const World &world, const std::string &end_reason, double wall_s);
// The same of an apparatus whose firmware is another process.
void write_journal(const std::filesystem::path &path, const Apparatus &apparatus, const std::string &end_reason);

} // namespace gonio::sim
