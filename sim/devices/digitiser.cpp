// digitiser.cpp: conversions, packets and strobe pulses in virtual time.
#include "digitiser.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gonio::sim {
namespace {

constexpr std::uint64_t double_width_every = 64;   // pulses
constexpr std::int64_t longest_step_ns = 10000000; // conversions are carried out in steps no longer than this
constexpr std::uint32_t most_samples_per_packet = 255;
constexpr std::uint8_t overflow_flag = 1; // bit 0 of the packet's flags

} // namespace

Digitiser::Digitiser(Scheduler &scheduler, const Digitiser_config &config, Convert convert, Strobe strobe, Ready ready)
    : scheduler_(scheduler), config_(config), convert_(std::move(convert)), strobe_(std::move(strobe)),
      ready_(std::move(ready)) {
    config_.packet_samples = std::clamp(config_.packet_samples, 1U, most_samples_per_packet);
}

bool Digitiser::start(std::uint32_t sample_period_us, std::uint32_t samples_per_strobe) {
    if (sample_period_us == 0 || samples_per_strobe == 0) {
        return false;
    }
    stop();
    running_ = true;
    ++run_;
    period_ps_ = std::llround(sample_period_us * 1e6 * (1.0 + 1e-6 * config_.clock_error_ppm));
    samples_per_strobe_ = samples_per_strobe;
    samples_per_step_ = static_cast<std::uint32_t>(std::max<std::int64_t>(1, longest_step_ns * 1000 / period_ps_));
    samples_per_step_ = std::min(samples_per_step_, config_.packet_samples);
    first_sample_ns_ = scheduler_.now_ns() + std::llround(config_.start_delay_us * 1e3);
    pulse_ = 0;
    next_sample_ = 0;
    packet_ = config_.first_packet;
    overflowed_ = false;
    schedule(first_sample_ns_, &Digitiser::rise);
    schedule(sample_time_ns(samples_per_step_ - 1), &Digitiser::convert_due);
    return true;
}

void Digitiser::stop() {
    if (strobe_high_) {
        strobe_high_ = false;
        strobe_(false);
    }
    running_ = false;
    filling_.clear();
    packets_.clear();
}

int Digitiser::read(std::uint8_t *buffer, std::size_t capacity) {
    if (packets_.empty()) {
        return 0;
    }
    std::vector<std::uint8_t> const packet = std::move(packets_.front());
    packets_.pop_front();
    // A USB host whose buffer is too short gets the beginning, and the rest is lost.
    std::size_t const length = std::min(capacity, packet.size());
    std::memcpy(buffer, packet.data(), length);
    return static_cast<int>(length);
}

std::int64_t Digitiser::sample_time_ns(std::uint64_t sample) const {
    // In picoseconds 64 bits hold 106 days.
    return first_sample_ns_ + (period_ps_ * static_cast<std::int64_t>(sample) + 500) / 1000;
}

void Digitiser::schedule(std::int64_t time_ns, void (Digitiser::*step)()) {
    scheduler_.at(time_ns, [this, step, run = run_] {
        if (running_ && run == run_) {
            (this->*step)();
        }
    });
}

void Digitiser::rise() {
    strobe_high_ = true;
    strobe_(true);
    std::int64_t const quarter_ns = static_cast<std::int64_t>(samples_per_strobe_) * period_ps_ / 4000;
    std::int64_t const width_ns = pulse_ % double_width_every == 0 ? 2 * quarter_ns : quarter_ns;
    ++pulse_;
    schedule(scheduler_.now_ns() + width_ns, &Digitiser::fall);
    schedule(sample_time_ns(pulse_ * samples_per_strobe_), &Digitiser::rise);
}

void Digitiser::fall() {
    strobe_high_ = false;
    strobe_(false);
}

void Digitiser::convert_due() {
    for (std::uint32_t i = 0; i < samples_per_step_; ++i) {
        filling_.push_back(convert_(next_sample_, sample_time_ns(next_sample_)));
        ++next_sample_;
        ++total_samples_;
        if (filling_.size() == config_.packet_samples) {
            send_packet();
        }
    }
    schedule(sample_time_ns(next_sample_ + samples_per_step_ - 1), &Digitiser::convert_due);
}

void Digitiser::send_packet() {
    gn_digitiser_packet header{};
    header.magic = 0x4744;
    header.packet = packet_++;
    header.first_sample = static_cast<std::uint32_t>(next_sample_ - filling_.size());
    header.count = static_cast<std::uint16_t>(filling_.size());
    std::size_t const body = filling_.size() * sizeof(gn_sample);
    std::vector<std::uint8_t> bytes(sizeof header + body);
    std::memcpy(bytes.data(), &header, sizeof header);
    std::memcpy(bytes.data() + sizeof header, filling_.data(), body);
    filling_.clear();
    if (packets_to_lose_ > 0) {
        --packets_to_lose_;
        ++packets_lost_;
        return;
    }
    std::int64_t const arrival_ns = scheduler_.now_ns() + std::llround(config_.packet_latency_us * 1e3);
    scheduler_.at(arrival_ns, [this, run = run_, packet = std::move(bytes)]() mutable {
        if (running_ && run == run_) {
            buffer(std::move(packet));
            ready_();
        }
    });
}

void Digitiser::buffer(std::vector<std::uint8_t> &&packet) {
    if (packets_.size() >= config_.most_waiting_packets) {
        overflowed_ = true;
        ++packets_lost_;
        return;
    }
    if (overflowed_) {
        overflowed_ = false;
        packet.at(offsetof(gn_digitiser_packet, flags)) |= overflow_flag;
    }
    packets_.push_back(std::move(packet));
}

} // namespace gonio::sim
