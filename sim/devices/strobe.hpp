// strobe.hpp: the strobe line as the kernel reports it: edges stamped late by the interrupt's latency, numbered, now
// and then lost.
#pragma once

#include <cstdint>
#include <functional>

#include "edge.h"
#include "random.hpp"
#include "scheduler.hpp"

namespace gonio::sim {

class Strobe_line {
public:
    using Deliver = std::function<void(const gn_edge &edge)>;

    Strobe_line(Scheduler &scheduler, std::uint64_t seed, double mean_latency_us, Deliver deliver);

    // The line changes now.
    void change(bool rising);
    // The next `pulses` pulses (both edges) are lost; counted: the kernel's edge numbers show the gap.
    void lose(std::uint32_t pulses, bool counted);
    // A spurious pulse of 2 us now.
    void disturb();
    [[nodiscard]] bool level() const { return level_; }
    [[nodiscard]] std::uint64_t edges() const { return edges_; }
    [[nodiscard]] std::uint64_t edges_lost() const { return edges_lost_; }

private:
    void report(bool rising);

    Scheduler &scheduler_;
    Random random_;
    double mean_latency_us_;
    Deliver deliver_;
    bool level_ = false;
    std::uint32_t number_ = 0;
    std::int64_t last_stamp_ns_ = 0;
    std::uint32_t pulses_to_lose_ = 0;
    bool losing_ = false;
    bool loss_counted_ = false;
    std::uint64_t edges_ = 0;
    std::uint64_t edges_lost_ = 0;
};

} // namespace gonio::sim
