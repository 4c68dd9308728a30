// low_discrepancy.hpp: a photon's first numbers as a point of a scrambled Sobol sequence: the photons' places,
// directions and first deflections fill their ranges evenly, and an average over N photons settles faster than 1 /
// sqrt(N).
#pragma once

#include <array>
#include <cstdint>

#include "random.hpp"

namespace gonio::sim {

// The point of photon n depends on seed and n alone. Sobol's sequence with the direction numbers of Joe and Kuo (2008),
// and Owen's scrambling by a hash that carries from higher binary places to lower ones (Laine and Karras 2011; Burley
// 2020): every seed gives another, unbiased, set of points. The sequence repeats after 2^32 photons: those that follow
// get another scramble.
class Low_discrepancy {
public:
    static constexpr std::size_t dimensions = Photon_random::most_given;
    using Point = std::array<std::uint32_t, dimensions>; // fractions in 2^-32, for Photon_random::give()

    explicit Low_discrepancy(std::uint64_t seed);
    // Not from two threads at once: keeps the scramble of the last photon.
    [[nodiscard]] Point at(std::uint64_t photon);

private:
    void choose_scramble(std::uint32_t repetition);

    std::uint64_t seed_;
    std::uint32_t repetition_ = 0;
    std::array<Point, 3> scramble_{};
};

} // namespace gonio::sim
