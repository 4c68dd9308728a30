// strobe.cpp: latency, numbers and losses of the strobe's edges.
#include "strobe.hpp"

#include <algorithm>
#include <cmath>

namespace gonio::sim {

Strobe_line::Strobe_line(Scheduler &scheduler, std::uint64_t seed, double mean_latency_us, Deliver deliver, Put put)
    : scheduler_(scheduler), random_(seed, Stream::strobe_latency), mean_latency_us_(mean_latency_us),
      deliver_(std::move(deliver)), put_(std::move(put)) {}

void Strobe_line::change(bool rising) {
    output_ = rising;
    if (stuck_) {
        return;
    }
    pass(rising);
    if (rising) {
        rose_ns_ = scheduler_.now_ns();
    } else if (pulses_to_double_ > 0) {
        --pulses_to_double_;
        std::int64_t const width_ns = scheduler_.now_ns() - rose_ns_;
        scheduler_.after(width_ns / 4, [this] { pass(true); });
        scheduler_.after(3 * width_ns / 4, [this] { pass(false); });
    }
}

void Strobe_line::pass(bool rising) {
    level_ = rising;
    if (rising && pulses_to_lose_ > 0) {
        --pulses_to_lose_;
        losing_ = true;
    }
    if (losing_) {
        ++edges_lost_;
        number_ += loss_counted_ ? 1U : 0U;
        losing_ = rising;
        return;
    }
    report(rising);
}

void Strobe_line::lose(std::uint32_t pulses, bool counted) {
    pulses_to_lose_ += pulses;
    loss_counted_ = counted;
}

void Strobe_line::disturb() {
    report(true);
    scheduler_.after(2000, [this] { report(false); });
}

void Strobe_line::stick(bool stuck) {
    stuck_ = stuck;
    if (bool const level = stuck || output_; level != level_) {
        pass(level);
    }
}

void Strobe_line::report(bool rising) {
    ++edges_;
    if (put_) {
        put_(rising);
    }
    std::int64_t const latency_ns = std::llround(1e3 * random_.exponential(edges_, mean_latency_us_));
    // Interrupts of one line are handled in order.
    std::int64_t const stamp_ns = std::max(scheduler_.now_ns() + latency_ns, last_stamp_ns_ + 1);
    last_stamp_ns_ = stamp_ns;
    gn_edge const edge{GN_LINE_STROBE, ++number_, rising, stamp_ns};
    scheduler_.at(stamp_ns, [this, edge] {
        if (deliver_) {
            deliver_(edge);
        }
    });
}

} // namespace gonio::sim
