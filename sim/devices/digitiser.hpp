// digitiser.hpp: the USB digitiser: converts on its own crystal, sends packets and drives the strobe
// (protocol/digitiser.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "gonio_records.h"
#include "scheduler.hpp"

namespace gonio::sim {

struct Digitiser_config {
    double clock_error_ppm = 0.0;     // its second is this much longer than the controller's
    double start_delay_us = 5000.0;   // START to the centre of sample 0
    double packet_latency_us = 800.0; // last conversion to the packet's arrival
    std::uint32_t packet_samples = 50;
    std::uint16_t first_packet = 0;         // counter of the first packet after START
    std::size_t most_waiting_packets = 256; // its own buffer: what comes to a full one is lost
};

class Digitiser {
public:
    // The sample whose window is centred at time_ns (controller clock); asked for within 20 ms after that.
    using Convert = std::function<gn_sample(std::uint64_t sample, std::int64_t time_ns)>;
    // The strobe line changes now.
    using Strobe = std::function<void(bool rising)>;
    // A packet can be read.
    using Ready = std::function<void()>;

    Digitiser(Scheduler &scheduler, const Digitiser_config &config, Convert convert, Strobe strobe, Ready ready);

    // false: a period or a K of 0.
    bool start(std::uint32_t sample_period_us, std::uint32_t samples_per_strobe);
    void stop();
    // Bytes of the oldest packet, 0 if none waits.
    int read(std::uint8_t *buffer, std::size_t capacity);
    // The next packet is lost on its way; the counter counts it.
    void lose_packet() { ++packets_to_lose_; }
    [[nodiscard]] std::uint64_t samples() const { return total_samples_; }
    // By fault, or because the buffer was full.
    [[nodiscard]] std::uint64_t packets_lost() const { return packets_lost_; }

private:
    [[nodiscard]] std::int64_t sample_time_ns(std::uint64_t sample) const;
    void schedule(std::int64_t time_ns, void (Digitiser::*step)());
    void convert_due();
    void rise();
    void fall();
    void send_packet();
    void buffer(std::vector<std::uint8_t> &&packet);

    Scheduler &scheduler_;
    Digitiser_config config_;
    Convert convert_;
    Strobe strobe_;
    Ready ready_;
    std::uint32_t run_ = 0; // counts STARTs; what an earlier run scheduled is void
    bool running_ = false;
    bool strobe_high_ = false;
    std::int64_t first_sample_ns_ = 0;
    std::int64_t period_ps_ = 0;
    std::uint32_t samples_per_strobe_ = 0;
    std::uint32_t samples_per_step_ = 1;
    std::uint64_t pulse_ = 0;
    std::uint64_t next_sample_ = 0;
    std::uint16_t packet_ = 0;
    std::vector<gn_sample> filling_;
    std::deque<std::vector<std::uint8_t>> packets_;
    std::uint64_t total_samples_ = 0;
    std::uint32_t packets_to_lose_ = 0;
    std::uint64_t packets_lost_ = 0;
    bool overflowed_ = false; // since the last packet that went into the buffer
};

} // namespace gonio::sim
