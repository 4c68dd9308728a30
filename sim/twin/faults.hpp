// faults.hpp: carries out the faults that a scenario or somebody at the running twin asks for, and counts them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "can_bus.hpp"
#include "digitiser.hpp"
#include "drive.hpp"
#include "interlocks.hpp"
#include "scenario.hpp"
#include "strobe.hpp"

namespace gonio::sim {

// What the faults act on.
struct Fault_targets {
    Scheduler &scheduler;
    Can_bus &bus;
    std::array<std::unique_ptr<Drive>, axis_count> &drives;
    Strobe_line &strobe;
    Digitiser &digitiser;
    Interlocks &interlocks;
    std::function<void()> silence_host; // none: there is no host to silence
};

class Fault_injector {
public:
    // Faults timed from power-up are scheduled at once.
    Fault_injector(const std::vector<Fault> &faults, const Fault_targets &targets);
    // Happens at_s from now.
    void inject(const Fault &fault);
    // Undoes what can be undone: silent and missing nodes, blocked axes, open lines, a strobe that is stuck or doubled,
    // losses that are still to come.
    void clear();
    // The next path began to move.
    void path_began();
    // Name and how often it happened, e.g. {"sync_lost", 1}.
    [[nodiscard]] const std::map<std::string, std::uint64_t> &injected() const { return injected_; }

private:
    void happen(const Fault &fault);
    void happen_to_drive(const Fault &fault);
    void watch_bus();
    Frame_fate judge(const gn_can_frame &frame, std::int64_t &delay_ns);

    std::vector<Fault> faults_;
    Fault_targets targets_;
    std::uint32_t paths_ = 0;
    std::uint32_t syncs_to_lose_ = 0;
    std::map<std::uint32_t, std::pair<std::uint32_t, std::int64_t>>
        tpdos_to_delay_; // identifier: how many, by how much
    std::map<std::string, std::uint64_t> injected_;
};

} // namespace gonio::sim
