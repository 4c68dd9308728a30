// strobe_line.hpp: a strobe line with a known truth: one-sided exponential latency, and faults put in by hand.
#ifndef GONIO_TEST_STROBE_LINE_HPP
#define GONIO_TEST_STROBE_LINE_HPP

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

extern "C" {
#include "sample_clock.h"
}

namespace gonio::test {

struct Strobe_line {
    gn_sample_clock clock{};
    std::mt19937_64 random;
    double origin_ns = 5.0e9;
    double sample_period_ns = 1.0e6;
    std::int64_t samples_per_strobe = 10;
    double mean_latency_ns = 50e3;
    std::uint32_t number = 0; // of the last edge on the line, heard or not

    explicit Strobe_line(std::uint64_t seed) : random(seed) {}

    void start(std::int64_t settle_ms = 2000) {
        gn_clock_settings const settings = {1000000, static_cast<std::uint32_t>(samples_per_strobe),
                                            settle_ms * 1000000, 25};
        gn_sample_clock_start(&clock, &settings);
    }

    double truth_ns(std::int64_t sample) const { return origin_ns + static_cast<double>(sample) * sample_period_ns; }
    double strobe_ns(std::int64_t strobe) const { return truth_ns(strobe * samples_per_strobe); }

    std::int64_t late(double time_ns) {
        // By hand and not by std::exponential_distribution, whose numbers differ between libraries.
        double const uniform = (static_cast<double>(random() >> 11u) + 0.5) * 0x1p-53;
        return std::llround(time_ns - mean_latency_ns * std::log(uniform));
    }

    void edge(bool rising, std::int64_t stamp_ns) {
        gn_edge const edge = {GN_LINE_STROBE, ++number, rising, stamp_ns};
        gn_sample_clock_edge(&clock, &edge);
    }

    void pulse_at(std::int64_t strobe, double shift_ns) {
        double const period_ns = sample_period_ns * static_cast<double>(samples_per_strobe);
        double const width_ns = strobe % 64 == 0 ? period_ns / 2 : period_ns / 4;
        std::int64_t const up_ns = late(strobe_ns(strobe) + shift_ns);
        edge(true, up_ns);
        edge(false, std::max(up_ns + 1, late(strobe_ns(strobe) + shift_ns + width_ns)));
    }

    void pulse(std::int64_t strobe) { pulse_at(strobe, 0.0); }

    void pulses(std::int64_t from, std::int64_t to) {
        for (std::int64_t strobe = from; strobe < to; ++strobe) {
            pulse(strobe);
        }
    }

    // Error of the fitted time of a sample, ns; the fit must be there.
    double error_ns(std::int64_t strobe, bool *settled) {
        gn_clock_fit fit{};
        *settled = gn_sample_clock_fit(&clock, std::llround(strobe_ns(strobe)), &fit);
        std::int64_t const sample = strobe * samples_per_strobe;
        return static_cast<double>(gn_clock_time_ns(&fit, sample)) - truth_ns(sample);
    }
};

} // namespace gonio::test

#endif
