// direction_index.hpp: the detector's directions, indexed on the sphere, so that photons stream through: each hit adds
// to the few apertures that contain it, and no photon is kept.
#pragma once

#include <span>

#include "estimate.hpp"
#include "hit_store.hpp"
#include "place.hpp"
#include "tracer.hpp"

namespace gonio::sim {

// For apertures up to about a degree; a hit costs time for each that holds it. Larger ones: Batched_readings.
class Direction_index final : public Hit_sink {
public:
    // Unit vectors of the sample frame to the apertures' centres.
    Direction_index(std::span<const Vector> directions, double half_angle_rad, double acceptance_half_angle_rad,
                    unsigned workers);
    void take(std::span<const Receiver_hit> hits, unsigned worker) override;
    // Over all workers, in the order of the directions. None may be taking hits meanwhile.
    [[nodiscard]] Aperture_sums sums();
    // In use; the same however many hits come.
    [[nodiscard]] std::size_t bytes() const;

private:
    // Hits wait until there are many, then they are added tile by tile: all that a tile's hits touch stays in cache.
    struct Worker {
        std::vector<Stored_hit> waiting;
        std::vector<Stored_hit> sorted;
        std::vector<std::uint32_t> of_tile; // hits that wait, per tile
        std::vector<Tally> tallies;
    };
    // Cells are numbered tile by tile.
    static constexpr std::size_t tile_side = 16;
    static constexpr std::size_t tile_cells = tile_side * tile_side;
    [[nodiscard]] std::size_t cell_at(unsigned face, std::size_t column, std::size_t row) const {
        std::size_t const tile = (face * tiles_ + column / tile_side) * tiles_ + row / tile_side;
        return tile * tile_cells + column % tile_side * tile_side + row % tile_side;
    }
    [[nodiscard]] std::size_t cell_of(const Place &place) const {
        std::uint64_t const side = tiles_ * tile_side;
        return cell_at(face_of(place), ((place.u >> 2U) * side) >> place_bits, ((place.v >> 2U) * side) >> place_bits);
    }
    template <typename Visit> void visit_cells(const Vector &aperture, const Visit &visit) const;
    void list_candidates();
    void add_waiting(Worker &worker) const;
    void add(const Stored_hit &hit, std::vector<Tally> &tallies) const;

    double least_cosine_;
    Half_angle half_angle_;
    std::size_t tiles_;                     // along a face's side
    std::vector<Vector> centres_;           // sorted by the cell of their centre: neighbours in memory as on the sphere
    std::vector<std::uint32_t> order_;      // which direction each of them was
    std::vector<std::uint32_t> starts_;     // per cell, into candidates_
    std::vector<std::uint32_t> candidates_; // apertures that may hold a hit in the cell
    std::vector<Worker> workers_;
};

} // namespace gonio::sim
