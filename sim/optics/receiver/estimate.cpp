// estimate.cpp: values and standard errors of apertures; photons still to trace.
#include "estimate.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "elementary.hpp"
#include "weight.hpp"

namespace gonio::sim {

Aperture_sums &Aperture_sums::operator+=(const Aperture_sums &other) {
    auto const add_to = [](std::vector<std::uint64_t> &sums, const std::vector<std::uint64_t> &more) {
        std::transform(sums.begin(), sums.end(), more.begin(), sums.begin(), std::plus<>());
    };
    add_to(weight, other.weight);
    add_to(square, other.square);
    add_to(hits, other.hits);
    return *this;
}

double cap_sr(double half_angle_rad) {
    double const half_sine = sine_cosine(0.5 * std::min(half_angle_rad, std::numbers::pi)).sine;
    return 4.0 * std::numbers::pi * half_sine * half_sine;
}

Estimate estimate(std::uint64_t weight, std::uint64_t square, std::uint64_t hits, std::uint64_t photons,
                  double half_angle_rad) {
    Estimate result;
    result.half_angle_rad = half_angle_rad;
    result.hits = hits;
    if (photons > 0) {
        double const number = static_cast<double>(photons);
        double const per_photon_sr = 1.0 / (number * cap_sr(half_angle_rad));
        double const sum = static_cast<double>(weight) * weight_unit;
        double const variance = static_cast<double>(square) * weight_unit - sum * sum / number;
        result.dsf_per_sr = sum * per_photon_sr;
        result.standard_error_per_sr = std::sqrt(std::max(variance, 0.0)) * per_photon_sr;
    }
    return result;
}

Precision precision(const Aperture_sums &sums, std::uint64_t photons, double relative_error, double least_share) {
    double mean = 0.0;
    for (std::uint64_t const weight : sums.weight) {
        mean += static_cast<double>(weight) / static_cast<double>(sums.size());
    }
    std::vector<double> errors;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        if (sums.hits[i] > 0 && static_cast<double>(sums.weight[i]) >= least_share * mean) {
            Estimate const value = estimate(sums.weight[i], sums.square[i], sums.hits[i], photons, 1.0);
            errors.push_back(value.standard_error_per_sr / value.dsf_per_sr);
        }
    }
    Precision result;
    result.lit = errors.size();
    if (errors.empty()) {
        result.further_photons = photons;
        return result;
    }
    auto const middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    result.median_relative_error = *middle;
    double const missing = *middle / relative_error * (*middle / relative_error) - 1.0;
    if (missing > 0.0) {
        result.further_photons =
            static_cast<std::uint64_t>(std::min(std::ceil(1.05 * missing * static_cast<double>(photons)), 0x1p62));
    }
    return result;
}

} // namespace gonio::sim
