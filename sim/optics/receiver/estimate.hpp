// estimate.hpp: sums over a detector's aperture, and what they say: a value with its standard error, and how many more
// photons a wanted error needs.
#pragma once

#include <cstdint>
#include <vector>

namespace gonio::sim {

// Of one aperture, in whole weights (weight.hpp): tallies add up in any order to the same bits.
struct Tally {
    std::uint64_t weight = 0;
    std::uint64_t square = 0;
    std::uint64_t hits = 0;

    Tally &operator+=(const Tally &other) {
        weight += other.weight;
        square += other.square;
        hits += other.hits;
        return *this;
    }
};

// Of many apertures, in the order of their directions.
struct Aperture_sums {
    std::vector<std::uint64_t> weight;
    std::vector<std::uint64_t> square;
    std::vector<std::uint64_t> hits;

    explicit Aperture_sums(std::size_t apertures = 0) : weight(apertures), square(apertures), hits(apertures) {}
    [[nodiscard]] std::size_t size() const { return weight.size(); }
    void add(std::size_t aperture, const Tally &tally) {
        weight[aperture] += tally.weight;
        square[aperture] += tally.square;
        hits[aperture] += tally.hits;
    }
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

// How far a run has come.
struct Precision {
    double median_relative_error = 0.0; // over the lit readings
    std::uint64_t lit = 0;
    std::uint64_t further_photons = 0; // to bring that median to the goal
};

// A reading is lit if its weight is at least `least_share` of the mean over all readings. A dark one has no relative
// error worth photons: a stray hit here and there around a mirror's peak would otherwise keep the run going for ever.
// Nothing lit yet: as many photons again. Errors fall with the root of the photon number; a twentieth is added so that
// the goal is reached at once rather than just missed.
Precision precision(const Aperture_sums &sums, std::uint64_t photons, double relative_error, double least_share = 0.01);

} // namespace gonio::sim
