// material_checks.hpp: what every material is held against: its samples against its density, its shares against its
// albedo.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "material.hpp"

namespace gonio::sim {

inline Arrival arrival(double theta_deg, double phi_deg = 0.0, bool from_front = true) {
    double const theta = theta_deg * std::numbers::pi / 180.0;
    double const phi = phi_deg * std::numbers::pi / 180.0;
    return {{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)}, from_front, {}};
}

inline bool is_ideal(const Arrival &light, const Vector &direction) {
    Vector const mirror{-light.towards.x, -light.towards.y, light.towards.z};
    return length(direction - mirror) < 1e-9 || length(direction + light.towards) < 1e-9;
}

// Sums over patches of theta and phi, from the normal to its opposite, and the ideal part.
struct Histogram {
    static constexpr int rings = 36;
    static constexpr int sectors = 36;
    static constexpr int size = rings * sectors;
    static std::size_t patch(const Vector &direction) {
        double const theta = std::acos(std::clamp(direction.z, -1.0, 1.0));
        double const phi = std::atan2(direction.y, direction.x) + std::numbers::pi;
        auto const index = [](double fraction, int most) {
            return static_cast<std::size_t>(std::min(static_cast<int>(fraction * most), most - 1));
        };
        return index(theta / std::numbers::pi, rings) * sectors + index(0.5 * phi / std::numbers::pi, sectors);
    }
    std::vector<double> sum = std::vector<double>(size, 0.0);
    std::vector<double> squares = std::vector<double>(size, 0.0);
    double ideal = 0.0;
    double ideal_squares = 0.0;
    double largest = 0.0;
};

inline Histogram draw(const Material &material, const Arrival &light, int photons, std::uint64_t seed) {
    Histogram histogram;
    for (int photon = 0; photon < photons; ++photon) {
        Photon_random random(seed, static_cast<std::uint64_t>(photon));
        Departure const departure = material.scatter(light, random);
        histogram.largest = std::max(histogram.largest, departure.share);
        if (departure.share == 0.0) {
            continue;
        }
        EXPECT_NEAR(length(departure.direction), 1.0, 1e-12);
        if (is_ideal(light, departure.direction)) {
            histogram.ideal += departure.share;
            histogram.ideal_squares += departure.share * departure.share;
            continue;
        }
        std::size_t const patch = Histogram::patch(departure.direction);
        histogram.sum[patch] += departure.share;
        histogram.squares[patch] += departure.share * departure.share;
    }
    return histogram;
}

// Integral of the density over each patch, per photon.
inline std::vector<double> integrate_patches(const Material &material, const Arrival &light, int steps) {
    int const rings = Histogram::rings * steps;
    int const sectors = Histogram::sectors * steps;
    double const step = std::numbers::pi / rings;
    std::vector<double> sums(Histogram::size, 0.0);
    for (int ring = 0; ring < rings; ++ring) {
        double const sine = std::sin((ring + 0.5) * step);
        double const cosine = std::cos((ring + 0.5) * step);
        // Exact area of the ring, so that a constant is integrated exactly.
        double const area = (std::cos(ring * step) - std::cos((ring + 1) * step)) * 2.0 * std::numbers::pi / sectors;
        for (int sector = 0; sector < sectors; ++sector) {
            double const phi = (sector + 0.5) * 2.0 * std::numbers::pi / sectors;
            Vector const direction{-sine * std::cos(phi), -sine * std::sin(phi), cosine};
            int const patch = ring / steps * Histogram::sectors + sector / steps;
            sums[static_cast<std::size_t>(patch)] += area * material.dsf_per_sr(light, direction);
        }
    }
    return sums;
}

// Chi-square of samples against density as a normal deviate (Wilson and Hilferty 1931). Cells with few photons are
// taken together. The variance of a sum of weights is its expectation times the mean weight.
inline double chi_square_deviate(const Histogram &histogram, const std::vector<double> &expected, int photons) {
    constexpr double least_photons = 30.0;
    double chi_square = 0.0;
    int freedom = 0;
    double rest_sum = 0.0;
    double rest_expected = 0.0;
    double rest_squares = 0.0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        double const wanted = expected[i] * photons;
        double const weight = histogram.sum[i] > 0.0 ? histogram.squares[i] / histogram.sum[i] : 0.0;
        if (weight > 0.0 && wanted > least_photons * weight) {
            chi_square += (histogram.sum[i] - wanted) * (histogram.sum[i] - wanted) / (wanted * weight);
            ++freedom;
        } else {
            rest_sum += histogram.sum[i];
            rest_expected += wanted;
            rest_squares += histogram.squares[i];
        }
    }
    if (rest_squares > least_photons * rest_sum) {
        ADD_FAILURE() << "weights are not bounded";
    }
    if (rest_expected > least_photons) {
        double const weight = rest_sum > 0.0 ? rest_squares / rest_sum : 1e-9;
        chi_square += (rest_sum - rest_expected) * (rest_sum - rest_expected) / (rest_expected * weight);
        ++freedom;
    } else {
        EXPECT_LT(rest_sum, 4.0 * least_photons);
    }
    double const width = 2.0 / (9.0 * freedom);
    return (std::cbrt(chi_square / freedom) - (1.0 - width)) / std::sqrt(width);
}

struct Expectations {
    int photons = 100000;
    double largest_share = 1.0 + 1e-12;
    double quadrature = 1e-3; // error of the integral of the density over the hemispheres
    int steps = 9;            // of that quadrature, per patch and side
};

// All of it for one incidence: the samples follow the density, ideal parts are the rest of the albedo, shares are
// bounded.
inline void check_material(const Material &material, const Arrival &light, const Expectations &expect = {}) {
    Histogram const histogram = draw(material, light, expect.photons, 2026);
    std::vector<double> const expected = integrate_patches(material, light, expect.steps);
    double scattered = 0.0;
    double sum = histogram.ideal;
    double squares = histogram.ideal_squares;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        scattered += expected[i];
        sum += histogram.sum[i];
        squares += histogram.squares[i];
    }
    Albedo const albedo = material.albedo(light);
    double const total = albedo.reflectance + albedo.transmittance;
    double const photons = expect.photons;
    double const mean = sum / photons;
    double const error = std::sqrt(std::max(squares / photons - mean * mean, 0.0) / photons);
    EXPECT_NEAR(mean, total, 4.0 * error + 1e-12);
    double const ideal = histogram.ideal / photons;
    double const ideal_error = std::sqrt(std::max(histogram.ideal_squares / photons - ideal * ideal, 0.0) / photons);
    EXPECT_NEAR(scattered + ideal, total, expect.quadrature + 4.0 * ideal_error);
    EXPECT_LE(histogram.largest, expect.largest_share);
    EXPECT_LT(chi_square_deviate(histogram, expected, expect.photons), 4.0);
}

} // namespace gonio::sim
