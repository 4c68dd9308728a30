// test_detector.cpp: gains, saturation, dark, and noise of the stated size that depends on seed and sample number
// alone.
#include <cmath>

#include <gtest/gtest.h>

#include "detector.hpp"

namespace gonio::sim {

TEST(Detector, GainsDarkAndTemperature) {
    Detector_config config;
    config.dark_counts = {350.0, -12.0};
    config.dark_drift_counts_per_s = {1.0, 0.0};
    config.dark_counts_per_c = {10.0, 2.0};
    config.temperature_drift_c_per_s = 0.5;
    Detector const detector(1, config);
    gn_sample const s = detector.convert(0, 4.0, 100.25, 1000.0, 1.0);
    EXPECT_EQ(s.high_counts, 100250 + 350 + 4 + 20);
    EXPECT_EQ(s.low_counts, 1000 - 12 + 4);
    EXPECT_EQ(s.monitor_counts, 4000000);
    EXPECT_EQ(s.temperature_centi_c, 2700);
    EXPECT_EQ(s.flags, 0);
}

TEST(Detector, SaturatesAtFullScaleAndSaysSo) {
    Detector const detector(1, {});
    gn_sample const s = detector.convert(0, 0.0, 9000.0, 9000.0, 1.0);
    EXPECT_EQ(s.high_counts, 8388607);
    EXPECT_EQ(s.low_counts, 9000);
    EXPECT_EQ(s.flags, GN_SAMPLE_HIGH_SATURATED);
}

TEST(Detector, NoiseHasTheStatedVarianceAndShotNoiseIsCommon) {
    Detector_config config;
    config.noise_counts_rms = {0.0, 50.0};
    config.shot_noise = 4.0;
    config.high_gain = 100.0;
    Detector const detector(5, config);
    int const n = 40000;
    double high_2 = 0.0;
    double low_2 = 0.0;
    double both = 0.0;
    for (int i = 0; i < n; ++i) {
        gn_sample const s = detector.convert(static_cast<std::uint64_t>(i), 0.0, 2500.0, 2500.0, 1.0);
        double const high = s.high_counts / 100.0 - 2500.0;
        double const low = s.low_counts - 2500.0;
        high_2 += high * high;
        low_2 += low * low;
        both += high * low;
    }
    // A sample variance scatters by sqrt(2 / n): 0.7 %; five times that.
    EXPECT_NEAR(high_2 / n, 4.0 * 2500.0, 0.035 * 1e4);
    EXPECT_NEAR(low_2 / n, 4.0 * 2500.0 + 2500.0, 0.035 * 12500.0);
    EXPECT_NEAR(both / n, 1e4, 0.04 * 1e4);
}

TEST(Random, CountersGiveTheSameValueInAnyOrder) {
    Random const a(3, Stream::shot);
    Random const b(3, Stream::low_noise);
    EXPECT_EQ(a.normal(1000), Random(3, Stream::shot).normal(1000));
    EXPECT_NE(a.normal(1000), b.normal(1000));
    EXPECT_NE(a.normal(1000), a.normal(1001));
    double sum = 0.0;
    double square = 0.0;
    double fourth = 0.0;
    int const n = 200000;
    for (int i = 0; i < n; ++i) {
        double const x = a.normal(static_cast<std::uint64_t>(i));
        sum += x;
        square += x * x;
        fourth += x * x * x * x;
    }
    EXPECT_NEAR(sum / n, 0.0, 5.0 / std::sqrt(n));
    EXPECT_NEAR(square / n, 1.0, 5.0 * std::sqrt(2.0 / n));
    // Twelve uniforms: a kurtosis of 3 - 1.2 / 12.
    EXPECT_NEAR(fourth / n, 2.9, 0.1);
}

} // namespace gonio::sim
