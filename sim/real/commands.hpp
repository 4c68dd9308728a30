// commands.hpp: what can be asked of the running twin by its control socket: how it is, faults, and who mounts the
// sample.
#pragma once

#include <array>
#include <atomic>
#include <limits>
#include <string>

#include "apparatus.hpp"
#include "can_wire.hpp"

namespace gonio::sim {

// How far the axes have been, which a test asks for afterwards.
class Furthest {
public:
    Furthest() {
        least_deg_.fill(std::numeric_limits<double>::infinity());
        most_deg_.fill(-std::numeric_limits<double>::infinity());
    }
    void see(const std::array<double, axis_count> &q_deg);
    [[nodiscard]] std::string json() const;

private:
    std::array<double, axis_count> least_deg_{};
    std::array<double, axis_count> most_deg_{};
};

class Commands {
public:
    // wire: null if the drives are on no bus. ended: what "quit" sets.
    Commands(Apparatus &apparatus, Can_wire *wire, const Furthest &furthest, std::atomic<bool> &ended)
        : apparatus_(apparatus), wire_(wire), furthest_(furthest), ended_(ended) {}
    // One line in, one JSON object back: {"ok": true}, {"error": "..."}, or the state.
    std::string obey(const std::string &line);

private:
    [[nodiscard]] std::string state() const;
    std::string fault(const std::string &arguments);

    Apparatus &apparatus_;
    Can_wire *wire_;
    const Furthest &furthest_;
    std::atomic<bool> &ended_;
};

} // namespace gonio::sim
