// hit_map.hpp: a stored photon map: answers any aperture anywhere on the sphere. Rows of hits with running sums: an
// aperture costs its rim, not its area.
#pragma once

#include <span>
#include <vector>

#include "estimate.hpp"
#include "tracer.hpp"

namespace gonio::sim {

// A hit as it is kept: 12 bytes.
struct Stored_hit {
    std::int32_t height; // z of `place`, in 2^-31
    std::uint32_t turn;  // azimuth, in 2^-32 turns
    std::uint32_t weight;
};

class Hit_store final : public Hit_sink {
public:
    Hit_store(double acceptance_half_angle_rad, unsigned workers);
    void take(std::span<const Receiver_hit> hits, unsigned worker) override;
    // The hits of all workers; they leave the store. Their order depends on the threads, what a map makes of them does not.
    [[nodiscard]] std::vector<Stored_hit> release();

private:
    double least_cosine_;
    std::vector<std::vector<Stored_hit>> kept_;
};

class Hit_map {
public:
    // `photons` emitted in all.
    Hit_map(std::vector<Stored_hit> hits, std::uint64_t photons);

    // The fixed aperture of a detector: unbiased.
    [[nodiscard]] Estimate fixed(const Vector &direction, double half_angle_rad) const;
    // The cap that holds the nearest `bandwidth` hits, at most `most_half_angle_rad`; (k - 1) / k removes its bias.
    [[nodiscard]] Estimate nearest(const Vector &direction, std::uint32_t bandwidth, double most_half_angle_rad) const;
    // Raw sums, to be added over several maps.
    [[nodiscard]] Aperture_sums sums(std::span<const Vector> directions, double half_angle_rad, unsigned threads) const;
    [[nodiscard]] std::size_t bytes() const;
};

} // namespace gonio::sim
