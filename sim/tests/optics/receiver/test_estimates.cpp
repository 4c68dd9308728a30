// test_estimates.cpp: what apertures say of known densities: their mean, their standard error, their bias.
#include <gtest/gtest.h>

#include "drawn_hits.hpp"
#include "hit_map.hpp"
#include "progressive.hpp"

namespace gonio::sim {

namespace {

constexpr double sigmas = 4.0;

// Values against what each should be: all together within 4 sigma, and chi-square that of right standard errors.
void expect_agreement(const std::vector<Estimate> &values, const std::vector<double> &truth) {
    double difference = 0.0;
    double variance = 0.0;
    double chi_square = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        double const miss = values[i].dsf_per_sr - truth[i];
        double const error2 = values[i].standard_error_per_sr * values[i].standard_error_per_sr;
        difference += miss;
        variance += error2;
        chi_square += miss * miss / error2;
    }
    EXPECT_LT(std::abs(difference), sigmas * std::sqrt(variance));
    double const number = static_cast<double>(values.size());
    EXPECT_NEAR(chi_square, number, sigmas * std::sqrt(2.0 * number));
}

// Photons of a cosine (or constant) density; half of them weigh 0.4, half 1.6.
Hit_map drawn_map(std::uint64_t photons, bool cosine) {
    std::vector<Receiver_hit> hits;
    for (std::uint64_t i = 0; i < photons; ++i) {
        Photon_random random(7, i);
        double const share = random.uniform();
        double const theta = std::acos(cosine ? std::sqrt(share) : 2.0 * share - 1.0);
        hits.push_back(radial_hit(at_angles(theta, 2.0 * std::numbers::pi * random.uniform()), i % 2 == 0 ? 0.4 : 1.6));
    }
    return {stored(hits), photons};
}

Hit_map lobe_map(std::uint64_t seed, std::uint64_t photons, const Vector &axis, double sharpness) {
    std::vector<Receiver_hit> hits;
    for (std::uint64_t i = 0; i < photons; ++i) {
        Photon_random random(seed, i);
        hits.push_back(radial_hit(in_lobe(axis, sharpness, random), 1.0));
    }
    return {stored(hits), photons};
}

double lobe_in_cap_per_sr(double sharpness, double half_angle) {
    return lobe_share(sharpness, half_angle) / cap_sr(half_angle);
}

} // namespace

TEST(Estimate, SolidAngleOfACap) {
    EXPECT_NEAR(cap_sr(0.5 * std::numbers::pi), 2.0 * std::numbers::pi, 1e-13);
    EXPECT_NEAR(cap_sr(4.0), 4.0 * std::numbers::pi, 1e-13);
    EXPECT_NEAR(cap_sr(1e-5) / (std::numbers::pi * 1e-10), 1.0, 1e-10);
}

TEST(Estimate, ErrorIsThatOfTheMeanOverPhotons) {
    // 30 of 100 photons seen, each of weight 2: variance of a binomial.
    Estimate const value =
        estimate(30 * std::uint64_t{whole_weight(2.0)}, 30 * whole_square(whole_weight(2.0)), 30, 100, 0.1);
    EXPECT_NEAR(value.dsf_per_sr * cap_sr(0.1), 0.6, 1e-12);
    EXPECT_NEAR(value.standard_error_per_sr * cap_sr(0.1), 2.0 * std::sqrt(0.3 * 0.7 / 100.0), 1e-12);
}

TEST(Estimate, FixedApertureIsUnbiasedOnEvenLight) {
    Hit_map const map = drawn_map(400000, false);
    std::vector<Estimate> values;
    for (const Vector &direction : spread_directions(500)) {
        values.push_back(map.fixed(direction, 2.0 * degree));
    }
    expect_agreement(values, std::vector<double>(values.size(), 0.25 / std::numbers::pi));
}

TEST(Estimate, FixedApertureIsUnbiasedOnACosine) {
    Hit_map const map = drawn_map(400000, true);
    double const half_angle = 2.5 * degree;
    std::vector<Estimate> values;
    std::vector<double> truth;
    for (const Vector &direction : spread_directions(300, 0.3)) {
        values.push_back(map.fixed(direction, half_angle));
        truth.push_back(direction.z / std::numbers::pi * 0.5 * (1.0 + std::cos(half_angle)));
    }
    expect_agreement(values, truth);
}

TEST(Estimate, PeakIsAveragedOverTheAperture) {
    double const sharpness = 1.0 / (0.5 * degree * 0.5 * degree);
    Vector const axis = at_angles(2.3, 3.14);
    Hit_map const map = lobe_map(8, 100000, axis, sharpness);
    for (double const half_angle_deg : {0.05, 0.28, 0.6, 1.0, 1.5}) {
        Estimate const value = map.fixed(axis, half_angle_deg * degree);
        double const truth = lobe_in_cap_per_sr(sharpness, half_angle_deg * degree);
        EXPECT_LT(std::abs(value.dsf_per_sr - truth), sigmas * value.standard_error_per_sr) << half_angle_deg;
    }
}

TEST(Estimate, NearestHitsAreUnbiasedOnEvenLight) {
    // Without (k - 1) / k they would read 5 % high: 9 sigma.
    Hit_map const map = drawn_map(400000, false);
    std::vector<Vector> const directions = spread_directions(2000);
    std::vector<Estimate> const values = map.nearest(directions, 20, 10.0 * degree, 2);
    double const truth = 0.25 / std::numbers::pi;
    double sum = 0.0;
    double square = 0.0;
    double claimed = 0.0;
    for (const Estimate &value : values) {
        EXPECT_EQ(value.hits, 20U);
        sum += value.dsf_per_sr / truth - 1.0;
        square += (value.dsf_per_sr / truth - 1.0) * (value.dsf_per_sr / truth - 1.0);
        claimed += value.standard_error_per_sr * value.standard_error_per_sr / (value.dsf_per_sr * value.dsf_per_sr);
    }
    EXPECT_LT(std::abs(sum), sigmas * std::sqrt(square));
    // The skew of 1 / area widens the error of the variance: 10 % is 4 sigma.
    EXPECT_NEAR(claimed / square, 1.0, 0.1);
}

TEST(Estimate, NearestHitsFlattenAPeakAsTheirCapDoes) {
    // The cap that holds a share m of the lobe reads m / -ln(1 - m) of its peak.
    double const sharpness = 1.0 / (0.5 * degree * 0.5 * degree);
    Vector const axis = at_angles(0.9, 1.0);
    Hit_map const map = lobe_map(9, 20000, axis, sharpness);
    double const peak = sharpness / (2.0 * std::numbers::pi);
    for (std::uint32_t const bandwidth : {2000U, 6000U}) {
        Estimate const value = map.nearest(axis, bandwidth, 20.0 * degree);
        double const share = bandwidth / 20000.0;
        double const flattened = share / -std::log1p(-share);
        EXPECT_LT(flattened, 0.95);
        EXPECT_LT(std::abs(value.dsf_per_sr / peak - flattened),
                  sigmas * value.standard_error_per_sr / value.dsf_per_sr);
    }
}

TEST(Estimate, TooFewNearHitsAreReadByTheWidestAperture) {
    Vector const axis = {0.0, 0.0, 1.0};
    Hit_map const map = lobe_map(10, 500, axis, 1e6);
    Estimate const value = map.nearest(axis, 501, 5.0 * degree);
    EXPECT_EQ(value.hits, 500U);
    EXPECT_EQ(value.half_angle_rad, 5.0 * degree);
    EXPECT_EQ(value.dsf_per_sr, map.fixed(axis, 5.0 * degree).dsf_per_sr);
}

TEST(Estimate, NearestHitsInOnePointAreFinite) {
    Vector const point = at_angles(0.7, 0.3);
    Hit_map const map(stored(std::vector<Receiver_hit>(1000, radial_hit(point, 1.0))), 1000);
    Estimate const value = map.nearest(point, 10, 5.0 * degree);
    EXPECT_EQ(value.hits, 1000U);
    EXPECT_TRUE(std::isfinite(value.dsf_per_sr));
}

TEST(Progressive, ConvergesToThePeakAsItsCapsShrink) {
    double const sharpness = 1.0 / (1.0 * degree * degree);
    Vector const axis = at_angles(1.2, 0.0);
    double const first = 3.0 * degree;
    Progressive_readings readings(std::vector<Vector>{axis}, first);
    double expected = 0.0;
    double share = 1.0;
    constexpr int batches = 40;
    for (int batch = 0; batch < batches; ++batch) {
        EXPECT_NEAR(cap_sr(readings.half_angle_rad()) / cap_sr(first), share, 1e-12);
        share *= (batch + 1.0 + Progressive_readings::usual_alpha) / (batch + 2.0);
        expected += lobe_in_cap_per_sr(sharpness, readings.half_angle_rad()) / batches;
        readings.add(lobe_map(100 + static_cast<std::uint64_t>(batch), 4000, axis, sharpness), 1);
    }
    double const peak = sharpness / (2.0 * std::numbers::pi);
    Estimate const value = readings.estimates()[0];
    EXPECT_LT(std::abs(value.dsf_per_sr - expected), sigmas * value.standard_error_per_sr);
    EXPECT_LT(value.standard_error_per_sr, 0.01 * peak);
    // From 22 % of the peak to more than 40 %.
    EXPECT_LT(lobe_in_cap_per_sr(sharpness, first), 0.23 * peak);
    EXPECT_GT(value.dsf_per_sr, 0.4 * peak);
}

TEST(Progressive, OnEvenLightIsUnbiasedWithTheRightError) {
    std::vector<Vector> const directions = spread_directions(400);
    Progressive_readings readings(directions, 4.0 * degree);
    for (std::uint64_t batch = 0; batch < 8; ++batch) {
        std::vector<Receiver_hit> hits;
        for (std::uint64_t i = 0; i < 25000; ++i) {
            Photon_random random(200 + batch, i);
            hits.push_back(radial_hit(anywhere(random), 1.0));
        }
        readings.add(Hit_map(stored(hits), 25000), 2);
    }
    expect_agreement(readings.estimates(), std::vector<double>(400, 0.25 / std::numbers::pi));
}

TEST(Precision, IsTheMedianOfLitReadings) {
    Aperture_sums sums(7);
    std::uint64_t const one = whole_weight(1.0);
    std::uint64_t const hits[] = {100, 400, 900, 1, 0, 1600, 2500};
    for (std::size_t i = 0; i < 7; ++i) {
        sums.add(i, {hits[i] * one, hits[i] * one, hits[i]});
    }
    // Mean 786: the reading of one hit counts as dark. Of 100, 400, 900, 1600 and 2500 hits the middle one has 1/30.
    Precision const reached = precision(sums, 1000000, 0.02);
    EXPECT_EQ(reached.lit, 5U);
    EXPECT_NEAR(reached.median_relative_error, 1.0 / 30.0, 2e-5);
    EXPECT_NEAR(static_cast<double>(reached.further_photons), 1.05 * (25.0 / 9.0 - 1.0) * 1e6, 3e3);
    EXPECT_EQ(precision(sums, 1000000, 0.04).further_photons, 0U);
    EXPECT_EQ(precision(sums, 1000000, 0.02, 0.0).lit, 6U);
    EXPECT_EQ(precision(Aperture_sums(3), 500, 0.02).further_photons, 500U);
}

TEST(Precision, IsReachedWithTheFurtherPhotons) {
    std::vector<Vector> const directions = spread_directions(500);
    auto const median = [&](std::uint64_t photons) {
        return precision(drawn_map(photons, false).sums(directions, 3.0 * degree, 1), photons, 0.1);
    };
    Precision const early = median(40000);
    EXPECT_GT(early.median_relative_error, 0.1);
    EXPECT_LT(median(40000 + early.further_photons).median_relative_error, 0.1);
}

} // namespace gonio::sim
