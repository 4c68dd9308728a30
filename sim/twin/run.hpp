// run.hpp: the main loops of the twin: lock-step in virtual time, or paced by the wall clock.
#pragma once

#include <atomic>
#include <string>

#include "lockstep_link.hpp"
#include "world.hpp"

namespace gonio::sim {

// Nobody said anything for too long; the text names who is waited for.
class Stalled : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// Until the clients are gone and the instrument is at rest and dark, or `ended`; says why it ended. Throws Stalled
// after patience_s of wall time without progress.
std::string run_virtual(World &world, Lockstep_link &link, double patience_s, const std::atomic<bool> &ended);

// Until `ended`.
std::string run_paced(World &world, Lockstep_link &link, const std::atomic<bool> &ended);

} // namespace gonio::sim
