// random.hpp: counter-based random numbers, keyed by photon: what photon 7 draws depends on seed and 7 alone, whoever
// traces it. Philox4x32-10 (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3").
#pragma once

#include <array>
#include <cstdint>

namespace gonio::sim {

using Philox_block = std::array<std::uint32_t, 4>;

inline Philox_block philox4x32(Philox_block counter, std::array<std::uint32_t, 2> key) {
    for (int round = 0; round < 10; ++round) {
        std::uint64_t const a = std::uint64_t{0xD2511F53U} * counter[0];
        std::uint64_t const b = std::uint64_t{0xCD9E8D57U} * counter[2];
        counter = {static_cast<std::uint32_t>(b >> 32U) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
                   static_cast<std::uint32_t>(a >> 32U) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
        key[0] += 0x9E3779B9U;
        key[1] += 0xBB67AE85U;
    }
    return counter;
}

// The numbers of one photon, in the order in which it asks for them. The first `point.size()` of them may be given
// (a low-discrepancy point); the rest are Philox's.
class Photon_random {
public:
    Photon_random(std::uint64_t seed, std::uint64_t photon)
        : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U)}, photon_(photon) {}

    // Uniform in (0, 1), a multiple of 2^-33: never 0 and never 1.
    double uniform() {
        std::uint32_t const bits = given_ < given_end_ ? given_numbers_[given_++] : next();
        return (static_cast<double>(bits) + 0.5) * 0x1p-32;
    }

    static constexpr std::size_t most_given = 8;
    // Numbers to hand out before Philox's own, as 32-bit fractions.
    void give(const std::array<std::uint32_t, most_given> &numbers, std::size_t count) {
        given_numbers_ = numbers;
        given_ = 0;
        given_end_ = count;
    }

private:
    std::uint32_t next() {
        if (used_ == 4) {
            block_ = philox4x32(
                {static_cast<std::uint32_t>(photon_), static_cast<std::uint32_t>(photon_ >> 32U), number_++, 0}, key_);
            used_ = 0;
        }
        return block_[used_++];
    }

    std::array<std::uint32_t, 2> key_;
    std::uint64_t photon_;
    std::uint32_t number_ = 0;
    std::size_t used_ = 4;
    std::size_t given_ = 0;
    std::size_t given_end_ = 0;
    Philox_block block_{};
    std::array<std::uint32_t, most_given> given_numbers_{};
};

} // namespace gonio::sim
