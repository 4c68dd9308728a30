// detector.hpp: from light to counts: two gains, lamp monitor, temperature; noise, dark offset and drift.
#pragma once

#include <array>
#include <cstdint>

#include "gonio_records.h"
#include "random.hpp"

namespace gonio::sim {

// Pairs: high gain, low gain.
struct Detector_config {
    double high_gain = 1000.0; // of the high channel, relative to the low one
    std::int32_t full_scale_counts = 8388607;
    std::array<double, 2> noise_counts_rms = {0.0, 0.0};
    double shot_noise = 0.0; // variance of the light in low-gain counts, per count
    std::array<double, 2> dark_counts = {0.0, 0.0};
    std::array<double, 2> dark_drift_counts_per_s = {0.0, 0.0};
    std::array<double, 2> dark_counts_per_c = {0.0, 0.0}; // from temperature_c
    double temperature_c = 25.0;
    double temperature_drift_c_per_s = 0.0;
    double monitor_counts = 4.0e6;
    double monitor_noise_counts_rms = 0.0;
    double lamp_drift_per_s = 0.0;
    double lamp_ripple = 0.0; // relative amplitude
    double lamp_ripple_period_s = 60.0;
};

class Detector {
public:
    Detector(std::uint64_t seed, const Detector_config &config);

    // The lamp's power relative to power-up.
    [[nodiscard]] double lamp(double time_s) const;
    // `number` must never repeat within a run: it picks the noise. Light in noise-free low-gain counts.
    [[nodiscard]] gn_sample convert(std::uint64_t number, double time_s, double high_light, double low_light,
                                    double monitored_lamp) const;

private:
    [[nodiscard]] std::int32_t digitise(double counts, std::uint32_t flag, std::uint16_t &flags) const;

    Detector_config config_;
    Random shot_;
    std::array<Random, 2> amplifier_;
    Random monitor_;
};

} // namespace gonio::sim
