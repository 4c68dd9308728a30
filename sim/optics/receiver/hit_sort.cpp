// hit_sort.cpp: two passes of an in-place radix sort (American flag sort, McIlroy et al. 1993), then halving of the
// squares that are still crowded.
#include "hit_sort.hpp"

#include <algorithm>
#include <numeric>

#include "over_threads.hpp"

namespace gonio::sim {

namespace {

constexpr unsigned most_levels = 12;
constexpr std::size_t hits_per_square = 2;

std::uint32_t leading(std::uint32_t word, unsigned bits) {
    return bits == 0 ? 0 : word >> (32U - bits);
}

// Sorts by `key`, which is below `starts.size() - 1`. `starts`: where each key's hits begin.
template <typename Key> void flag_sort(std::span<Stored_hit> hits, std::vector<std::uint32_t> &starts, const Key &key) {
    std::fill(starts.begin(), starts.end(), 0U);
    for (const Stored_hit &hit : hits) {
        ++starts[key(hit.place) + 1];
    }
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    std::vector<std::uint32_t> next(starts.begin(), starts.end() - 1);
    for (std::size_t bucket = 0; bucket < next.size(); ++bucket) {
        while (next[bucket] < starts[bucket + 1]) {
            Stored_hit hit = hits[next[bucket]];
            for (std::size_t home = key(hit.place); home != bucket; home = key(hit.place)) {
                std::swap(hit, hits[next[home]++]);
            }
            hits[next[bucket]++] = hit;
        }
    }
}

// A square of `level` that holds these hits.
void halve(std::span<Stored_hit> hits, unsigned level) {
    if (hits.size() <= crowd || level == place_bits) {
        return;
    }
    auto const by = [level](std::uint32_t Place::*word) {
        return [level, word](const Stored_hit &hit) { return !upper_half(hit.place.*word, level); };
    };
    auto const part = [level](std::span<Stored_hit> rows, const auto &lower) {
        auto const middle = std::partition(rows.begin(), rows.end(), lower);
        auto const size = static_cast<std::size_t>(middle - rows.begin());
        halve(rows.first(size), level + 1);
        halve(rows.subspan(size), level + 1);
    };
    auto const middle = std::partition(hits.begin(), hits.end(), by(&Place::u));
    auto const size = static_cast<std::size_t>(middle - hits.begin());
    part(hits.first(size), by(&Place::v));
    part(hits.subspan(size), by(&Place::v));
}

} // namespace

Hit_grid sort_hits(std::span<Stored_hit> hits, unsigned threads) {
    Hit_grid grid;
    while (grid.level < most_levels && hits.size() >= (hits_per_square * cube_faces) << 2U * (grid.level + 1)) {
        ++grid.level;
    }
    std::size_t const side = grid.side();
    std::vector<std::uint32_t> columns(cube_faces * side + 1);
    flag_sort(hits, columns, [&](const Place &place) { return face_of(place) * side + leading(place.u, grid.level); });

    grid.starts.resize(cube_faces * side * side + 1);
    grid.starts.back() = static_cast<std::uint32_t>(hits.size());
    over_threads(cube_faces * side, threads, [&](std::size_t column) {
        std::uint32_t const first = columns[column];
        std::span<Stored_hit> const inside = hits.subspan(first, columns[column + 1] - first);
        std::vector<std::uint32_t> rows(side + 1);
        flag_sort(inside, rows, [&](const Place &place) { return leading(place.v, grid.level); });
        for (std::size_t row = 0; row < side; ++row) {
            grid.starts[column * side + row] = first + rows[row];
            halve(inside.subspan(rows[row], rows[row + 1] - rows[row]), grid.level);
        }
    });
    return grid;
}

} // namespace gonio::sim
