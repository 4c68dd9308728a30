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
    using Put = std::function<void(bool high)>;

    // deliver: the edge as a kernel would report it, at its stamp. put: the line's level, at once, for a real line.
    // Either may be empty.
    Strobe_line(Scheduler &scheduler, std::uint64_t seed, double mean_latency_us, Deliver deliver, Put put);

    // The digitiser's output changes now.
    void change(bool rising);
    // The next `pulses` pulses (both edges) are lost; counted: the kernel's edge numbers show the gap. A real line does
    // not show them.
    void lose(std::uint32_t pulses, bool counted);
    // A spurious pulse of 2 us now.
    void disturb();
    // The line stays high whatever the digitiser does; false: it follows again.
    void stick(bool stuck);
    // Each of the next `pulses` pulses comes twice: the second, half as wide, a quarter of its width later.
    void double_pulses(std::uint32_t pulses) { pulses_to_double_ = pulses; }
    [[nodiscard]] bool level() const { return level_; }
    [[nodiscard]] std::uint64_t edges() const { return edges_; }
    [[nodiscard]] std::uint64_t edges_lost() const { return edges_lost_; }

private:
    void pass(bool rising);
    void report(bool rising);

    Scheduler &scheduler_;
    Random random_;
    double mean_latency_us_;
    Deliver deliver_;
    Put put_;
    bool output_ = false; // the digitiser's
    bool level_ = false;
    bool stuck_ = false;
    std::int64_t rose_ns_ = 0;
    std::uint32_t pulses_to_double_ = 0;
    std::uint32_t number_ = 0;
    std::int64_t last_stamp_ns_ = 0;
    std::uint32_t pulses_to_lose_ = 0;
    bool losing_ = false;
    bool loss_counted_ = false;
    std::uint64_t edges_ = 0;
    std::uint64_t edges_lost_ = 0;
};

} // namespace gonio::sim
