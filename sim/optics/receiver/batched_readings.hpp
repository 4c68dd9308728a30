// batched_readings.hpp: large apertures, where a hit belongs to so many that adding it to each costs more than sorting:
// hits are kept until there are many, then a map of them is read at all directions, and they are forgotten.
#pragma once

#include <mutex>
#include <span>
#include <vector>

#include "hit_map.hpp"

namespace gonio::sim {

// Same sums, to the last bit, as those of a Direction_index; memory does not grow with the photons.
class Batched_readings final : public Hit_sink {
public:
    static constexpr std::size_t usual_batch = std::size_t{4} << 20U;
    // `most_hits`: kept at a time, by all workers together.
    Batched_readings(std::span<const Vector> directions, double half_angle_rad, double acceptance_half_angle_rad,
                     unsigned workers, std::size_t most_hits = usual_batch);
    void take(std::span<const Receiver_hit> hits, unsigned worker) override;
    // In the order of the directions. None may be taking hits meanwhile.
    [[nodiscard]] Aperture_sums sums();

private:
    struct alignas(64) Kept {
        std::vector<Stored_hit> hits;
    };
    void read(Kept &kept, unsigned threads);

    std::vector<Vector> directions_;
    double half_angle_rad_;
    double least_cosine_;
    std::size_t batch_; // of one worker
    std::vector<Kept> kept_;
    std::mutex mutex_; // of sums_: once per batch
    Aperture_sums sums_;
};

} // namespace gonio::sim
