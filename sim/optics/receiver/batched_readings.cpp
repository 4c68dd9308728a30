// batched_readings.cpp: each worker reads its own batches; whole numbers add up to the same however hits were dealt
// out.
#include "batched_readings.hpp"

#include <algorithm>
#include <utility>

namespace gonio::sim {

Batched_readings::Batched_readings(std::span<const Vector> directions, double half_angle_rad,
                                   double acceptance_half_angle_rad, unsigned workers, std::size_t most_hits)
    : directions_(directions.begin(), directions.end()), half_angle_rad_(half_angle_rad),
      least_cosine_(least_arrival_cosine(acceptance_half_angle_rad)),
      batch_(std::max<std::size_t>(most_hits / workers, 1)), kept_(workers), sums_(directions.size()) {}

void Batched_readings::take(std::span<const Receiver_hit> hits, unsigned worker) {
    Kept &kept = kept_[worker];
    for (const Receiver_hit &hit : hits) {
        if (arrives_within(hit, least_cosine_)) {
            if (kept.hits.empty()) {
                kept.hits.reserve(batch_);
            }
            kept.hits.push_back({place_of(hit.place), hit.weight});
            if (kept.hits.size() == batch_) {
                read(kept, 1);
            }
        }
    }
}

void Batched_readings::read(Kept &kept, unsigned threads) {
    Hit_map const map(std::exchange(kept.hits, {}), 0, threads);
    Aperture_sums const sums = map.sums(directions_, half_angle_rad_, threads);
    std::scoped_lock const lock(mutex_);
    sums_ += sums;
}

Aperture_sums Batched_readings::sums() {
    for (Kept &kept : kept_) {
        if (!kept.hits.empty()) {
            read(kept, static_cast<unsigned>(kept_.size()));
        }
    }
    return sums_;
}

} // namespace gonio::sim
