// detector.cpp: the detector head's electronics.
#include "detector.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gonio::sim {

Detector::Detector(std::uint64_t seed, const Detector_config &config)
    : config_(config),
      shot_(seed, Stream::shot), amplifier_{Random(seed, Stream::high_noise), Random(seed, Stream::low_noise)},
      monitor_(seed, Stream::monitor_noise) {}

double Detector::lamp(double time_s) const {
    double const phase = 2.0 * std::numbers::pi * time_s / config_.lamp_ripple_period_s;
    return 1.0 + config_.lamp_drift_per_s * time_s + config_.lamp_ripple * std::sin(phase);
}

gn_sample Detector::convert(std::uint64_t number, double time_s, double high_light, double low_light,
                            double monitored_lamp) const {
    double const warmer_c = config_.temperature_drift_c_per_s * time_s;
    // One photocurrent feeds both amplifiers: its shot noise is common to them.
    double const shot = config_.shot_noise > 0.0 ? shot_.normal(number) : 0.0;
    auto const channel = [&](std::size_t i, double light, double gain) {
        double const current = light + shot * std::sqrt(config_.shot_noise * std::max(light, 0.0));
        return gain * current + config_.dark_counts.at(i) + config_.dark_drift_counts_per_s.at(i) * time_s +
               config_.dark_counts_per_c.at(i) * warmer_c +
               config_.noise_counts_rms.at(i) * amplifier_.at(i).normal(number);
    };
    double const monitor =
        config_.monitor_counts * monitored_lamp + config_.monitor_noise_counts_rms * monitor_.normal(number);
    std::uint16_t flags = 0;
    gn_sample sample{};
    sample.high_counts = digitise(channel(0, high_light, config_.high_gain), GN_SAMPLE_HIGH_SATURATED, flags);
    sample.low_counts = digitise(channel(1, low_light, 1.0), GN_SAMPLE_LOW_SATURATED, flags);
    sample.monitor_counts = digitise(monitor, GN_SAMPLE_MONITOR_SATURATED, flags);
    sample.temperature_centi_c = static_cast<std::int16_t>(std::lround(100.0 * (config_.temperature_c + warmer_c)));
    sample.flags = flags;
    return sample;
}

std::int32_t Detector::digitise(double counts, std::uint32_t flag, std::uint16_t &flags) const {
    double const limit = config_.full_scale_counts;
    if (counts >= limit || counts <= -limit) {
        flags = static_cast<std::uint16_t>(flags | flag);
        return counts > 0.0 ? config_.full_scale_counts : -config_.full_scale_counts;
    }
    return static_cast<std::int32_t>(std::floor(counts + 0.5));
}

} // namespace gonio::sim
