// tracks.cpp: neighbours abeam on another turn; coarser tracks next to finer ones.
#include "tracks.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace gonio::sphere {

std::vector<double> track_distances(const Track &track, const Track_rules &rules) {
    constexpr double NONE = std::numeric_limits<double>::infinity();
    const std::size_t n = track.unit.size();
    std::vector<std::array<double, 2>> sides(n, {NONE, NONE});
    std::vector<double> result(n, NONE);
    const auto look = [&](std::int64_t a, std::int64_t b) {
        const Vec apart = track.unit[b] - track.unit[a];
        const double chord = length(apart);
        const bool elsewhere =
            track.path[a] != track.path[b] || std::fabs(track.length[a] - track.length[b]) > rules.round_about * chord;
        if (!elsewhere || std::fabs(dot(track.ahead[a], track.ahead[b])) <= rules.parallel) {
            return;
        }
        const double sine = dot(apart, cross(track.unit[a], track.ahead[a])) / chord;
        const double distance = angle_of_chord(chord) * std::fabs(sine);
        if (std::fabs(sine) > rules.abeam && distance > rules.same_track_rad) {
            double &side = sides[a][sine > 0.0 ? 0 : 1];
            side = std::min(side, distance);
        }
    };
    for_each_part(track.unit, false, [&](const Part_of_sphere &part) {
        const std::vector<std::int64_t> pairs = edges_of(part);
        for (std::size_t k = 0; k < pairs.size(); k += 2) {
            look(pairs[k], pairs[k + 1]);
            look(pairs[k + 1], pairs[k]);
        }
        for (std::size_t i = 0; i < n; ++i) {
            const auto [near, far] =
                std::minmax(sides[part.number[part.stands_for[i]]][0], sides[part.number[part.stands_for[i]]][1]);
            result[part.number[i]] = far <= rules.one_sided * near ? far : near;
        }
    });
    return result;
}

std::vector<double> coarsest_pitch(std::span<const Vec> unit, std::span<const double> pitch, double factor) {
    std::vector<double> result(pitch.begin(), pitch.end());
    for_each_part(unit, true, [&](const Part_of_sphere &part) {
        const std::vector<std::int64_t> pairs = edges_of(part);
        for (std::size_t k = 0; k < pairs.size(); k += 2) {
            const std::int64_t a = pairs[k];
            const std::int64_t b = pairs[k + 1];
            const double apart = angle_of_chord(length(unit[a] - unit[b]));
            if (apart <= factor * pitch[b]) {
                result[a] = std::max(result[a], pitch[b]);
            }
            if (apart <= factor * pitch[a]) {
                result[b] = std::max(result[b], pitch[a]);
            }
        }
        for (Index i = 0; i < part.real; ++i) {
            double &own = result[part.number[i]];
            own = std::max(own, result[part.number[part.stands_for[i]]]);
        }
    });
    return result;
}

} // namespace gonio::sphere
