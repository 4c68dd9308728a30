// test_latency.cpp: the histogram's bins double: every lateness falls into the one bin that its bounds say.
#include <gtest/gtest.h>

extern "C" {
#include "latency.h"
}

namespace {

TEST(Latency, each_bin_ends_below_its_power_of_two) {
    for (std::uint32_t bin = 0; bin < GN_LATENCY_BINS; bin++) {
        gn_latency latency{};
        std::int64_t const end_us = std::int64_t{1} << bin;
        std::int64_t const begin_us = bin == 0 ? 0 : end_us / 2;
        gn_latency_record(&latency, begin_us * 1000);
        gn_latency_record(&latency, end_us * 1000 - 1);
        EXPECT_EQ(latency.bins[bin], 2u) << bin;
        EXPECT_EQ(latency.max_us, static_cast<std::uint32_t>(end_us - 1));
        EXPECT_EQ(latency.wakeups, 2u);
    }
}

TEST(Latency, early_is_in_time_and_very_late_is_in_the_last_bin) {
    gn_latency latency{};
    gn_latency_record(&latency, -5'000'000);
    gn_latency_record(&latency, std::int64_t{5000} * 1'000'000'000); // more than 32 bits of microseconds
    EXPECT_EQ(latency.bins[0], 1u);
    EXPECT_EQ(latency.bins[GN_LATENCY_BINS - 1u], 1u);
    EXPECT_EQ(latency.max_us, UINT32_MAX);
}

} // namespace
