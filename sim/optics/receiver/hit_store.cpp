// hit_store.cpp: pieces of hits, one list per worker.
#include "hit_store.hpp"

#include <numbers>

#include "elementary.hpp"

namespace gonio::sim {

namespace {

constexpr std::size_t piece_hits = std::size_t{1} << 16U;

} // namespace

double least_arrival_cosine(double acceptance_half_angle_rad) {
    return acceptance_half_angle_rad >= 0.5 * std::numbers::pi ? -2.0 : sine_cosine(acceptance_half_angle_rad).cosine;
}

Hit_store::Hit_store(double acceptance_half_angle_rad, unsigned workers)
    : least_cosine_(least_arrival_cosine(acceptance_half_angle_rad)), kept_(workers) {}

void Hit_store::take(std::span<const Receiver_hit> hits, unsigned worker) {
    std::vector<Piece> &pieces = kept_[worker].pieces;
    for (const Receiver_hit &hit : hits) {
        if (arrives_within(hit, least_cosine_)) {
            if (pieces.empty() || pieces.back().size() == piece_hits) {
                pieces.emplace_back().reserve(piece_hits);
            }
            pieces.back().push_back({place_of(hit.place), hit.weight});
        }
    }
}

std::vector<Stored_hit> Hit_store::release() {
    std::size_t total = 0;
    for (const Kept &kept : kept_) {
        for (const Piece &piece : kept.pieces) {
            total += piece.size();
        }
    }
    std::vector<Stored_hit> hits;
    hits.reserve(total);
    for (Kept &kept : kept_) {
        for (Piece &piece : kept.pieces) {
            hits.insert(hits.end(), piece.begin(), piece.end());
            Piece().swap(piece);
        }
        kept.pieces.clear();
    }
    return hits;
}

} // namespace gonio::sim
