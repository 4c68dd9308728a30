// hit_store.hpp: keeps every hit, 12 bytes each, for a map.
#pragma once

#include <vector>

#include "place.hpp"
#include "tracer.hpp"

namespace gonio::sim {

// Light that arrives farther than the acceptance from the sphere's normal is not seen. From 90 degrees on: all is.
double least_arrival_cosine(double acceptance_half_angle_rad);
inline bool arrives_within(const Receiver_hit &hit, double least_cosine) {
    return dot(hit.place, hit.direction) >= least_cosine;
}

class Hit_store final : public Hit_sink {
public:
    Hit_store(double acceptance_half_angle_rad, unsigned workers);
    void take(std::span<const Receiver_hit> hits, unsigned worker) override;
    // The hits of all workers; they leave the store. Their order depends on the threads, what a map makes of them does
    // not.
    [[nodiscard]] std::vector<Stored_hit> release();

private:
    // In pieces of one size: they never move, and leave the store one by one.
    using Piece = std::vector<Stored_hit>;
    struct alignas(64) Kept {
        std::vector<Piece> pieces;
    };
    double least_cosine_;
    std::vector<Kept> kept_;
};

} // namespace gonio::sim
