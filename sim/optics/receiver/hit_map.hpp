// hit_map.hpp: a stored photon map: answers any aperture anywhere on the sphere. Columns of hits with running sums: an
// aperture costs its rim, not its area.
#pragma once

#include <span>
#include <vector>

#include "estimate.hpp"
#include "hit_sort.hpp"
#include "hit_store.hpp"
#include "place.hpp"

namespace gonio::sim {

class Hit_map {
public:
    // `photons` emitted in all. At most 2^32 - 1 hits. `threads` sort them.
    Hit_map(std::vector<Stored_hit> hits, std::uint64_t photons, unsigned threads = 1);

    // The fixed aperture of a detector: unbiased.
    [[nodiscard]] Estimate fixed(const Vector &direction, double half_angle_rad) const;
    [[nodiscard]] std::vector<Estimate> fixed(std::span<const Vector> directions, double half_angle_rad,
                                              unsigned threads) const;
    // Raw sums, to be added over several maps.
    [[nodiscard]] Aperture_sums sums(std::span<const Vector> directions, double half_angle_rad, unsigned threads) const;
    // The cap that holds the nearest `bandwidth` (at least 2) hits, at most `most_half_angle_rad`. Its rim passes
    // through the last of them, so k hits stand for k - 1: times (k - 1) / k it is unbiased where the light is even
    // (Fukunaga and Hostetler 1973). On a peak it reads low as any cap does that is wider than the peak, by about r^2 /
    // 8 times the Laplacian; unlike a detector's aperture its width follows the photon number and the scatter itself.
    // Beside a peak it may reach into it. Fewer hits within the most: the fixed aperture of that size.
    [[nodiscard]] Estimate nearest(const Vector &direction, std::uint32_t bandwidth, double most_half_angle_rad) const;
    [[nodiscard]] std::vector<Estimate> nearest(std::span<const Vector> directions, std::uint32_t bandwidth,
                                                double most_half_angle_rad, unsigned threads) const;

    [[nodiscard]] std::uint64_t photons() const { return photons_; }
    [[nodiscard]] std::size_t bytes() const;

private:
    // Part of a crowded square of the grid.
    struct Square {
        unsigned level; // its side is 2^-level of the face's
        double u;       // its centre
        double v;
        std::size_t first;
        std::size_t last;
    };
    struct Rims;
    class Summing;
    class Gathering;
    [[nodiscard]] Rims rims(double half_angle_rad) const;
    // A visitor is given stretches of hits that all belong to the aperture (`all`) and others to be tested (`some`).
    template <typename Visitor> void visit(const Vector &direction, const Rims &rims, Visitor &visitor) const;
    template <typename Visitor>
    void visit_face(const Vector &direction, const Rims &rims, unsigned face, Visitor &visitor) const;
    template <typename Visitor>
    void visit_rim(const Face_cap &cap, std::size_t column, std::size_t first_row, std::size_t last_row,
                   Visitor &visitor) const;
    template <typename Visitor> void visit_square(const Face_cap &cap, const Square &square, Visitor &visitor) const;
    [[nodiscard]] std::size_t half(std::size_t first, std::size_t last, std::uint32_t Place::*word,
                                   unsigned level) const;
    [[nodiscard]] Tally sum(const Vector &direction, const Rims &rims) const;
    [[nodiscard]] double enclosing_half_angle(const Vector &direction, std::uint32_t bandwidth, double most_rad) const;

    // Sums over all hits before every eighth.
    struct Running {
        std::uint64_t weight;
        std::uint64_t square;
    };
    std::uint64_t photons_;
    std::vector<Stored_hit> hits_;
    Hit_grid grid_;
    std::vector<Running> running_;
};

} // namespace gonio::sim
