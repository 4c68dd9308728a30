// random.hpp: counter-based random numbers: the value depends on (seed, stream, counter) alone, not on the order of
// asking.
#pragma once

#include <cmath>
#include <cstdint>

namespace gonio::sim {

// One stream per source of chance.
enum class Stream : std::uint64_t {
    shot = 1,
    high_noise = 2,
    low_noise = 3,
    monitor_noise = 4,
    strobe_latency = 5,
    sync_jitter = 6,
    echo_latency = 7,
};

class Random {
public:
    Random(std::uint64_t seed, Stream stream)
        : key_(mix(seed * 0x9E3779B97F4A7C15U + static_cast<std::uint64_t>(stream))) {}

    [[nodiscard]] std::uint64_t bits(std::uint64_t counter) const {
        return mix(key_ ^ mix(counter + 0xD1B54A32D192ED03U));
    }
    // In [0, 1).
    [[nodiscard]] double uniform(std::uint64_t counter) const {
        return static_cast<double>(bits(counter) >> 11U) * 0x1p-53;
    }
    [[nodiscard]] double exponential(std::uint64_t counter, double mean) const {
        return -mean * std::log(1.0 - uniform(counter));
    }
    // Zero mean, unit variance: the sum of twelve 16-bit uniforms, the same bits on every machine.
    [[nodiscard]] double normal(std::uint64_t counter) const {
        std::uint64_t sum = 0;
        for (std::uint64_t word = 0; word < 3; ++word) {
            std::uint64_t const lanes = bits(3 * counter + word);
            sum += (lanes & 0xFFFFU) + ((lanes >> 16U) & 0xFFFFU) + ((lanes >> 32U) & 0xFFFFU) + (lanes >> 48U);
        }
        return (static_cast<double>(sum) + 6.0) * 0x1p-16 - 6.0;
    }

private:
    // The finaliser of SplitMix64 (Steele, Lea, Flood 2014).
    static std::uint64_t mix(std::uint64_t z) {
        z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
        z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
        return z ^ (z >> 31U);
    }
    std::uint64_t key_;
};

} // namespace gonio::sim
