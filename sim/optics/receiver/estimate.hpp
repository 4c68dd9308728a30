// estimate.hpp: sums over a detector's aperture, and what they say: a value with its standard error.
#pragma once

#include <cstdint>
#include <vector>

namespace gonio::sim {

// Per aperture, in whole weights (weight.hpp): they add up in any order to the same bits.
struct Aperture_sums {
    std::vector<std::uint64_t> weight;
    std::vector<std::uint64_t> square;
    std::vector<std::uint64_t> hits;

    explicit Aperture_sums(std::size_t apertures = 0) : weight(apertures), square(apertures), hits(apertures) {}
    // Same number of apertures.
    Aperture_sums &operator+=(const Aperture_sums &other);
};

struct Estimate {
    double dsf_per_sr = 0.0;            // irradiance r^2 / power of the emitted photons
    double standard_error_per_sr = 0.0; // of independent photons
    double half_angle_rad = 0.0;        // of the aperture that was used
    std::uint64_t hits = 0;
};

// Solid angle of a cap [sr].
double cap_sr(double half_angle_rad);
// `photons` emitted in all. The variance of a mean of N photons: (sum w^2 - (sum w)^2 / N) / N^2.
Estimate estimate(std::uint64_t weight, std::uint64_t square, std::uint64_t hits, std::uint64_t photons,
                  double half_angle_rad);

} // namespace gonio::sim
