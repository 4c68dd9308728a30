// bench_report.hpp: a flight's result as JSON.
#pragma once

#include <map>
#include <string>

#include "bench_dialogue.hpp"

namespace gonio::sim {

// Members of an object, without its braces.
std::string flight_members(const Bench_result &result);
std::string counters_json(const gonio_Counters &counters);
// Per thread; bins as gonio.proto has them.
std::string latency_json(const std::map<int, gonio_Latency> &latency);

} // namespace gonio::sim
