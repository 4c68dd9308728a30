// tracks.cpp: neighbours abeam on another turn.
#include "tracks.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace gonio::sphere {

std::vector<Beside> track_distances(const Track &track, const Track_rules &rules) {
    constexpr double NONE = std::numeric_limits<double>::infinity();
    struct Side {
        double distance = NONE;
        double way = NONE;
    };
    const std::size_t n = track.unit.size();
    std::vector<std::array<Side, 2>> sides(n);
    std::vector<Beside> result(n, {NONE, NONE, NONE});
    const auto look = [&](std::int64_t a, std::int64_t b) {
        const Vec apart = track.unit[b] - track.unit[a];
        const double chord = length(apart);
        const double way = track.path[a] != track.path[b] ? NONE : std::fabs(track.length[a] - track.length[b]);
        if (way <= rules.round_about * chord || std::fabs(dot(track.ahead[a], track.ahead[b])) <= rules.parallel) {
            return;
        }
        const double sine = dot(apart, cross(track.unit[a], track.ahead[a])) / chord;
        const double distance = angle_of_chord(chord) * std::fabs(sine);
        Side &side = sides[a][sine > 0.0 ? 0 : 1];
        if (std::fabs(sine) > rules.abeam && distance > rules.same_track_rad && distance < side.distance) {
            side = {distance, way};
        }
    };
    for_each_part(track.unit, false, [&](const Part_of_sphere &part) {
        const std::vector<std::int64_t> pairs = edges_of(part);
        for (std::size_t k = 0; k < pairs.size(); k += 2) {
            look(pairs[k], pairs[k + 1]);
            look(pairs[k + 1], pairs[k]);
        }
        for (std::size_t i = 0; i < n; ++i) {
            const auto &[left, right] = sides[part.number[part.stands_for[i]]];
            const bool nearer = left.distance <= right.distance;
            result[part.number[i]] = {nearer ? left.distance : right.distance, nearer ? right.distance : left.distance,
                                      nearer ? left.way : right.way};
        }
    });
    return result;
}

} // namespace gonio::sphere
