// weight.hpp: a photon's weight as a whole number, so that sums do not depend on their order.
#pragma once

#include <cmath>
#include <cstdint>

namespace gonio::sim {

// Weights are counted in 2^-24 of a photon's power: sums in 64 bits hold 10^12 photons.
inline constexpr double weight_unit = 0x1p-24;
inline constexpr double most_weight = 255.0;

inline std::uint32_t whole_weight(double weight) {
    return static_cast<std::uint32_t>(std::floor(weight / weight_unit + 0.5));
}
// Square of a whole weight, in the same unit.
inline std::uint64_t whole_square(std::uint32_t weight) {
    return (static_cast<std::uint64_t>(weight) * weight + (1U << 23U)) >> 24U;
}

} // namespace gonio::sim
