// test_sample_clock.cpp: the fitted sample times against the known truth, with losses, extra and shifted edges.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>

#include "strobe_line.hpp"

namespace {

using gonio::test::Strobe_line;

TEST(Sample_clock, is_well_under_a_microsecond_with_a_ten_second_window) {
    double worst_ns = 0.0;
    double sum_ns2 = 0.0;
    double sum_ns = 0.0;
    double sum_residual_ns = 0.0;
    int count = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Strobe_line line(seed);
        line.sample_period_ns = 1.0e6 * (1.0 + 23e-6); // the digitiser's crystal is 23 ppm slow
        line.start();
        for (std::int64_t strobe = 0; strobe < 3000; ++strobe) {
            line.pulse(strobe);
            if (strobe >= 1100 && strobe % 10 == 0) { // with each block, at the window's newest end
                bool settled = false;
                double const error_ns = line.error_ns(strobe, &settled);
                ASSERT_TRUE(settled);
                worst_ns = std::max(worst_ns, std::abs(error_ns));
                sum_ns2 += error_ns * error_ns;
                sum_ns += error_ns;
                sum_residual_ns += line.clock.fit.residual_ns;
                ++count;
            }
        }
        EXPECT_NEAR(gn_clock_period_ns(&line.clock.fit), line.sample_period_ns, 0.5);
        EXPECT_EQ(line.clock.strobes, 3000u);
        EXPECT_EQ(line.clock.strobes_lost + line.clock.strobes_rejected + line.clock.strobe_realigned, 0u);
    }
    double const rms_ns = std::sqrt(sum_ns2 / count);
    std::printf(
        "sample clock, 50 us one-sided latency, 10 s window: mean %.0f ns, rms %.0f ns, maximum %.0f ns of %d\n",
        sum_ns / count, rms_ns, worst_ns, count);
    EXPECT_LT(rms_ns, 300.0);
    EXPECT_LT(worst_ns, 1500.0);
    EXPECT_NEAR(sum_residual_ns / count, 50e3, 2e3) << "the residual is the mean latency";
}

TEST(Sample_clock, is_not_used_before_it_has_settled) {
    Strobe_line line(3);
    line.start();
    bool settled = true;
    line.pulses(0, 199);
    line.error_ns(199, &settled);
    EXPECT_FALSE(settled);
    line.pulses(199, 205);
    double const error_ns = line.error_ns(204, &settled);
    EXPECT_TRUE(settled);
    EXPECT_LT(std::abs(error_ns), 5e3);
    line.error_ns(204 + 300, &settled);
    EXPECT_FALSE(settled) << "no strobe for 3 s";
}

TEST(Sample_clock, a_lost_edge_leaves_a_hole_and_no_error) {
    Strobe_line line(4);
    line.start();
    line.pulses(0, 400);
    line.number += 2; // the kernel dropped a pulse and numbered on
    line.pulses(401, 500);
    line.pulses(503, 800); // three pulses that never reached the kernel
    bool settled = false;
    EXPECT_LT(std::abs(line.error_ns(799, &settled)), 1500.0);
    EXPECT_TRUE(settled);
    EXPECT_EQ(line.clock.strobes, 796u);
    EXPECT_EQ(line.clock.strobes_lost, 4u);
    EXPECT_EQ(line.clock.strobes_rejected, 0u);
    EXPECT_EQ(line.clock.strobe_realigned, 0u);
}

TEST(Sample_clock, an_extra_edge_is_rejected) {
    Strobe_line line(5);
    line.start();
    line.pulses(0, 500);
    for (double const place : {0.3, 0.5, 0.7, 0.9, 0.999}) { // the last two are within the 25 % but come too early
        line.edge(true, std::llround(line.strobe_ns(499) + place * 10e6));
        line.edge(false, std::llround(line.strobe_ns(499) + place * 10e6 + 5000.0));
    }
    line.pulses(500, 800);
    bool settled = false;
    EXPECT_LT(std::abs(line.error_ns(799, &settled)), 1500.0);
    EXPECT_EQ(line.clock.strobes, 800u);
    EXPECT_EQ(line.clock.strobes_rejected, 5u);
    EXPECT_EQ(line.clock.strobes_lost, 0u);
}

TEST(Sample_clock, a_shifted_edge_is_rejected_or_harmless) {
    Strobe_line line(6);
    line.start();
    line.pulses(0, 500);
    line.pulse_at(500, 4.0e6); // outside the tolerance of 25 %
    line.pulse_at(501, -4.0e6);
    line.pulse_at(502, -1.0e6); // inside it, but a stamp is never early
    line.pulses(503, 600);
    line.pulse_at(600, 1.0e6); // inside it and late, as stamps are: it stays above the line
    line.pulses(601, 800);
    bool settled = false;
    EXPECT_LT(std::abs(line.error_ns(799, &settled)), 1500.0);
    EXPECT_TRUE(settled);
    EXPECT_EQ(line.clock.strobes_rejected, 3u);
    EXPECT_EQ(line.clock.strobes_lost, 0u) << "a rejected edge is not lost as well";
    EXPECT_EQ(line.clock.strobes, 797u);
    EXPECT_EQ(line.clock.strobe_realigned, 0u);
}

TEST(Sample_clock, edges_lost_at_the_start_are_found_by_the_double_width) {
    for (std::int64_t const lost : {1, 3, 31, 32}) {
        Strobe_line line(7);
        line.start();
        line.pulses(lost, 400); // what was lost left no number behind
        bool settled = false;
        EXPECT_LT(std::abs(line.error_ns(399, &settled)), 3000.0) << lost;
        EXPECT_TRUE(settled);
        EXPECT_EQ(line.clock.strobe_realigned, 1u);
        EXPECT_EQ(line.clock.strobes_lost, static_cast<std::uint64_t>(lost));
    }
}

TEST(Sample_clock, edges_lost_at_the_start_are_found_by_the_kernels_numbers) {
    Strobe_line line(8);
    line.number = 40; // edges of an earlier run
    gn_edge const earlier = {GN_LINE_STROBE, 40, false, 1};
    gn_sample_clock_edge(&line.clock, &earlier);
    line.start();
    line.number += 4;
    line.pulses(2, 400);
    bool settled = false;
    EXPECT_LT(std::abs(line.error_ns(399, &settled)), 3000.0);
    EXPECT_EQ(line.clock.strobe_realigned, 0u);
    EXPECT_EQ(line.clock.strobes_lost, 2u);
}

TEST(Sample_clock, numbers_are_not_trusted_before_a_double_width_pulse) {
    Strobe_line line(9);
    line.start(100);
    line.pulses(1, 60); // strobe 0 lost: 590 ms of strobes, but none of double width
    bool settled = true;
    line.error_ns(59, &settled);
    EXPECT_FALSE(settled);
    line.pulses(60, 66);
    EXPECT_LT(std::abs(line.error_ns(65, &settled)), 20e3);
    EXPECT_TRUE(settled);
}

TEST(Sample_clock, one_late_falling_edge_does_not_move_confirmed_numbers) {
    Strobe_line line(10);
    line.start();
    line.pulses(0, 300);
    std::int64_t const up_ns = line.late(line.strobe_ns(300));
    line.edge(true, up_ns);
    line.edge(false, up_ns + 5000000); // looks like double width
    line.pulses(301, 600);
    bool settled = false;
    EXPECT_LT(std::abs(line.error_ns(599, &settled)), 1500.0);
    EXPECT_EQ(line.clock.strobe_realigned, 0u);
}

TEST(Sample_clock, a_clock_that_steps_is_learnt_anew) {
    Strobe_line line(11);
    line.start();
    line.pulses(0, 500);
    line.origin_ns += 3.7e6; // more than the tolerance: every edge is out of place from here on
    line.pulses(500, 1000);
    bool settled = false;
    EXPECT_LT(std::abs(line.error_ns(999, &settled)), 1500.0);
    EXPECT_TRUE(settled);
    EXPECT_EQ(line.clock.strobes_rejected, 16u);
}

// A machine that stands still now and then hands over what has gathered all at once: no crystal is that wrong.
TEST(Sample_clock, edges_in_heaps_do_not_bend_the_period) {
    int wrong = 0;
    double worst = 0.0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        Strobe_line line(seed);
        gn_clock_settings const settings = {1000000, 10, 800000000, 45};
        gn_sample_clock_start(&line.clock, &settings);
        double free_ns = 0.0; // the machine stands still until then
        std::int64_t last_ns = 0;
        auto const handed_over = [&](double time_ns) {
            last_ns = std::max(line.late(std::max(time_ns, free_ns)), last_ns + 20000);
            return last_ns;
        };
        for (std::int64_t strobe = 0; strobe < 1000; ++strobe) {
            double const time_ns = line.strobe_ns(strobe);
            if (line.random() % 64 == 0) {
                free_ns = time_ns + 1e6 * static_cast<double>(5 + line.random() % 20);
            }
            line.edge(true, handed_over(time_ns));
            line.edge(false, handed_over(time_ns + (strobe % 64 == 0 ? 5e6 : 2.5e6)));
        }
        gn_clock_fit fit{};
        if (gn_sample_clock_fit(&line.clock, last_ns, &fit)) {
            double const off = std::abs(gn_clock_period_ns(&fit) / 1e6 - 1.0);
            worst = std::max(worst, off);
            wrong += off > 1.0001e-3 ? 1 : 0;
        }
    }
    EXPECT_EQ(wrong, 0) << "worst " << worst;
}

TEST(Sample_clock, times_keep_their_last_nanosecond_after_a_year) {
    gn_clock_fit const fit = {.reference_sample = INT64_C(31536000000),
                              .reference_ns = INT64_C(31536000000000003),
                              .nominal_period_ns = 1000000,
                              .excess_period_ns = 2.5,
                              .residual_ns = 0.0,
                              .window = 1000};
    EXPECT_EQ(gn_clock_time_ns(&fit, fit.reference_sample + 10000), INT64_C(31536010000025003));
    EXPECT_EQ(gn_clock_time_ns(&fit, fit.reference_sample - 1), fit.reference_ns - 1000003);
}

} // namespace
