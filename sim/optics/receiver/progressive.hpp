// progressive.hpp: apertures that shrink from batch to batch, so that bias and noise both vanish with the photon
// number.
#pragma once

#include <span>
#include <vector>

#include "hit_map.hpp"

namespace gonio::sim {

// Knaus and Zwicker 2011, "Progressive photon mapping: a probabilistic approach", after Hachisuka, Ogaki and Jensen
// 2008: batch i is read with caps of solid angle a_i, a_(i+1) = a_i (i + alpha) / (i + 1), and the batches are
// averaged. Each batch is biased as its cap is (about r_i^2 / 8 times the Laplacian, low on peaks); the bias of the
// mean falls as n^(alpha - 1), its variance as n^(-alpha): it tends to the scatter at a point, which no real detector
// sees.
class Progressive_readings {
public:
    static constexpr double usual_alpha = 0.7; // 0 to 1; 1: the aperture stays
    Progressive_readings(std::span<const Vector> directions, double first_half_angle_rad, double alpha = usual_alpha);

    // The next batch: disjoint photons, in the same order and of the same sizes for the same bits.
    void add(const Hit_map &batch, unsigned threads);
    // In the order of the directions; with the half angle of the last batch.
    [[nodiscard]] std::vector<Estimate> estimates() const;
    // That the next batch will be read with.
    [[nodiscard]] double half_angle_rad() const { return half_angle_rad_; }

private:
    struct Mean {
        double dsf = 0.0; // times photons
        double variance = 0.0;
        std::uint64_t hits = 0;
    };
    std::vector<Vector> directions_;
    double half_angle_rad_;
    double last_half_angle_rad_;
    double alpha_;
    double batches_ = 0.0;
    double photons_ = 0.0;
    std::vector<Mean> means_;
};

} // namespace gonio::sim
