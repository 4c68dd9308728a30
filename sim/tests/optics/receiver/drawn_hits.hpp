// drawn_hits.hpp: hits on the receiver sphere drawn from known densities, for the receiver's tests.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "hit_store.hpp"
#include "place.hpp"
#include "random.hpp"
#include "tracer.hpp"
#include "vector.hpp"

namespace gonio::sim {

inline constexpr double degree = std::numbers::pi / 180.0;

inline Vector at_angles(double theta, double phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

// A lobe exp(sharpness (cos t - 1)) about an axis (von Mises and Fisher): a Gaussian of sigma 1 / sqrt(sharpness) on
// the sphere, whose integral over a cap is elementary.
inline Vector in_lobe(const Vector &axis, double sharpness, Photon_random &random) {
    double const drop = -std::log1p(random.uniform() * std::expm1(-2.0 * sharpness)) / sharpness;
    double const sine = std::sqrt(drop * (2.0 - drop));
    double const phi = 2.0 * std::numbers::pi * random.uniform();
    return frame_about(axis).to_world({sine * std::cos(phi), sine * std::sin(phi), 1.0 - drop});
}
// Share of the lobe within an angle of its axis.
inline double lobe_share(double sharpness, double angle) {
    double const half_sine = std::sin(0.5 * angle);
    return std::expm1(-2.0 * sharpness * half_sine * half_sine) / std::expm1(-2.0 * sharpness);
}

inline Vector anywhere(Photon_random &random) {
    double const z = 2.0 * random.uniform() - 1.0;
    return at_angles(std::acos(z), 2.0 * std::numbers::pi * random.uniform());
}

inline Receiver_hit radial_hit(const Vector &place, double weight) {
    return {place, place, whole_weight(weight)};
}

// Directions spread evenly over the part of the sphere above a height (Fibonacci's spiral).
inline std::vector<Vector> spread_directions(std::size_t number, double lowest_z = -1.0) {
    std::vector<Vector> result;
    for (std::size_t i = 0; i < number; ++i) {
        double const share = (static_cast<double>(i) + 0.5) / static_cast<double>(number);
        result.push_back(at_angles(std::acos(1.0 - (1.0 - lowest_z) * share),
                                   static_cast<double>(i) * std::numbers::pi * (3.0 - std::sqrt(5.0))));
    }
    return result;
}

inline std::vector<Stored_hit> stored(const std::vector<Receiver_hit> &hits) {
    Hit_store store(std::numbers::pi, 1);
    store.take(hits, 0);
    return store.release();
}

} // namespace gonio::sim
