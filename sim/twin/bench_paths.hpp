// bench_paths.hpp: the requests that set the reference instrument up, and the paths that the in-process host flies.
#pragma once

#include <array>
#include <vector>

#include "gonio.pb.h"
#include "gonio_records.h"
#include "instrument.hpp"

namespace gonio::sim {

gonio_Request configure_request(const Instrument &instrument);
gonio_Request axis_request(const Instrument &instrument, std::size_t axis);

// From rest where the axes stand to rest where the flight begins.
std::vector<gn_knot> move_to_start(const Instrument &instrument, const std::array<double, axis_count> &from_counts);
// All axes in sinusoidal motion of nearly their full speed, with a smooth start and end of 3 s each.
std::vector<gn_knot> sinusoidal_flight(const Instrument &instrument, double duration_s);

} // namespace gonio::sim
