// hit_map.cpp: an aperture meets each column of a face's grid in one stretch of rows.
#include "hit_map.hpp"

#include <algorithm>
#include <stdexcept>

#include "elementary.hpp"
#include "over_threads.hpp"
#include "stretches.hpp"
#include "weight.hpp"

namespace gonio::sim {

namespace {

constexpr std::size_t run = 8;

// Calls work(i) for every direction, in an order in which the hits of one are still in the cache for the next.
template <typename Work> void for_neighbours(std::span<const Vector> directions, unsigned threads, const Work &work) {
    constexpr std::size_t at_once = 256;
    constexpr unsigned tile_bits = 7;
    std::vector<std::uint64_t> order(directions.size());
    for (std::size_t i = 0; i < directions.size(); ++i) {
        Place const place = place_of(directions[i]);
        std::uint64_t const column = face_of(place) << tile_bits | place.u >> (32U - tile_bits);
        order[i] = (column << tile_bits | place.v >> (32U - tile_bits)) << 32U | i;
    }
    std::sort(order.begin(), order.end());
    over_threads((order.size() + at_once - 1) / at_once, threads, [&](std::size_t piece) {
        std::size_t const last = std::min(order.size(), (piece + 1) * at_once);
        for (std::size_t i = piece * at_once; i < last; ++i) {
            work(static_cast<std::size_t>(order[i] & UINT32_MAX));
        }
    });
}

} // namespace

// Squares whose centre is within the outer rim may hold hits of the aperture; within the inner rim they hold no others.
struct Hit_map::Rims {
    Rims(double half_angle_rad, double square_rad)
        : aperture(half_angle_rad), outer(half_angle_rad + square_rad),
          inner(std::max(half_angle_rad - square_rad, 0.0)), has_inner(half_angle_rad > square_rad + 1e-7) {}
    Half_angle aperture;
    Half_angle outer;
    Half_angle inner;
    bool has_inner;
};

Hit_map::Hit_map(std::vector<Stored_hit> hits, std::uint64_t photons, unsigned threads)
    : photons_(photons), hits_(std::move(hits)) {
    if (hits_.size() > UINT32_MAX) {
        throw std::length_error("a photon map holds at most 4294967295 hits");
    }
    grid_ = sort_hits(hits_, threads);
    running_.reserve(hits_.size() / run + 1);
    Running sum{0, 0};
    for (std::size_t i = 0; i < hits_.size(); ++i) {
        if (i % run == 0) {
            running_.push_back(sum);
        }
        sum.weight += hits_[i].weight;
        sum.square += whole_square(hits_[i].weight);
    }
    running_.push_back(sum);
}

class Hit_map::Summing {
public:
    explicit Summing(const Hit_map &map) : hits_(map.hits_), running_(map.running_) {}

    void all(std::size_t first, std::size_t last) {
        std::size_t const low = (first + run - 1) / run;
        std::size_t const high = last / run;
        if (low >= high) {
            one_by_one(first, last);
            return;
        }
        one_by_one(first, low * run);
        one_by_one(high * run, last);
        tally += {running_[high].weight - running_[low].weight, running_[high].square - running_[low].square,
                  (high - low) * run};
    }
    void some(const Face_cap &cap, std::size_t first, std::size_t last) {
        Tally sum;
        for (const Stored_hit &hit : hits_.subspan(first, last - first)) {
            bool const held = holds(cap, face_coordinate(hit.place.u), face_coordinate(hit.place.v));
            // Without a branch: in a rim it would be a toss-up.
            std::uint32_t const weight = hit.weight & (0U - static_cast<std::uint32_t>(held));
            sum += {weight, whole_square(weight), static_cast<std::uint64_t>(held)};
        }
        tally += sum;
    }
    Tally tally;

private:
    void one_by_one(std::size_t first, std::size_t last) {
        for (const Stored_hit &hit : hits_.subspan(first, last - first)) {
            tally += {hit.weight, whole_square(hit.weight), 1};
        }
    }
    std::span<const Stored_hit> hits_;
    std::span<const Running> running_;
};

// Every hit of the aperture, with how near it is.
class Hit_map::Gathering {
public:
    struct Near {
        double cosine2; // of the angle to the aperture's centre, squared, with its sign
        std::uint32_t weight;
    };
    Gathering(const Hit_map &map, const Vector &direction, const Half_angle &angle)
        : hits_(map.hits_), direction_(direction), angle_(angle) {}

    void all(std::size_t first, std::size_t last) {
        if (first < last) {
            some(on_face(direction_, angle_, face_of(hits_[first].place)), first, last);
        }
    }
    void some(const Face_cap &cap, std::size_t first, std::size_t last) {
        for (const Stored_hit &hit : hits_.subspan(first, last - first)) {
            double const u = face_coordinate(hit.place.u);
            double const v = face_coordinate(hit.place.v);
            if (holds(cap, u, v)) {
                double const part = along(cap, u, v);
                near.push_back({part * std::abs(part) / squared_length(u, v), hit.weight});
            }
        }
    }
    std::vector<Near> near;

private:
    std::span<const Stored_hit> hits_;
    Vector direction_;
    Half_angle angle_;
};

std::size_t Hit_map::half(std::size_t first, std::size_t last, std::uint32_t Place::*word, unsigned level) const {
    auto const begin = hits_.begin();
    auto const middle =
        std::partition_point(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last),
                             [&](const Stored_hit &hit) { return !upper_half(hit.place.*word, level); });
    return static_cast<std::size_t>(middle - begin);
}

template <typename Visitor>
void Hit_map::visit_square(const Face_cap &cap, const Square &square, Visitor &visitor) const {
    if (square.last - square.first <= crowd || square.level == place_bits) {
        visitor.some(cap, square.first, square.last);
        return;
    }
    double const half_width = 1.0 / static_cast<double>(std::uint64_t{1} << square.level);
    Overlap const held = overlap(cap, square.u, square.v, half_width);
    if (held == Overlap::all) {
        visitor.all(square.first, square.last);
    } else if (held == Overlap::part) {
        double const step = 0.5 * half_width;
        std::size_t const middle = half(square.first, square.last, &Place::u, square.level);
        std::size_t const low = half(square.first, middle, &Place::v, square.level);
        std::size_t const high = half(middle, square.last, &Place::v, square.level);
        unsigned const level = square.level + 1;
        visit_square(cap, {level, square.u - step, square.v - step, square.first, low}, visitor);
        visit_square(cap, {level, square.u - step, square.v + step, low, middle}, visitor);
        visit_square(cap, {level, square.u + step, square.v - step, middle, high}, visitor);
        visit_square(cap, {level, square.u + step, square.v + step, high, square.last}, visitor);
    }
}

template <typename Visitor>
void Hit_map::visit_rim(const Face_cap &cap, std::size_t column, std::size_t first_row, std::size_t last_row,
                        Visitor &visitor) const {
    const std::uint32_t *starts = &grid_.starts[column * grid_.side()];
    if (starts[last_row] - starts[first_row] <= 2 * crowd) {
        visitor.some(cap, starts[first_row], starts[last_row]);
        return;
    }
    double const half_width = 1.0 / static_cast<double>(grid_.side());
    double const u = static_cast<double>(2 * (column % grid_.side()) + 1) * half_width - 1.0;
    for (std::size_t row = first_row; row < last_row; ++row) {
        double const v = static_cast<double>(2 * row + 1) * half_width - 1.0;
        visit_square(cap, {grid_.level, u, v, starts[row], starts[row + 1]}, visitor);
    }
}

template <typename Visitor>
void Hit_map::visit_face(const Vector &direction, const Rims &rims, unsigned face, Visitor &visitor) const {
    Face_cap const cap = on_face(direction, rims.aperture, face);
    if (overlap(cap, 0.0, 0.0, 1.0) == Overlap::none) {
        return;
    }
    double const side = static_cast<double>(grid_.side());
    Face_cap const outer = on_face(direction, rims.outer, face);
    Stretches const may_hold(outer, true);
    Stretches const hold_all(on_face(direction, rims.inner, face), false);
    Squares const columns(shadow(outer, outer.u), side);
    for (std::size_t i = columns.first; i < columns.last; ++i) {
        double const u = static_cast<double>(2 * i + 1) / side - 1.0;
        Squares const touched(may_hold.at(u), side);
        if (touched.first == touched.last) {
            continue;
        }
        std::size_t const column = face * grid_.side() + i;
        Squares const held(rims.has_inner ? hold_all.at(u) : Range{1.0, -1.0}, side);
        if (held.first == held.last) {
            visit_rim(cap, column, touched.first, touched.last, visitor);
        } else {
            const std::uint32_t *starts = &grid_.starts[column * grid_.side()];
            visit_rim(cap, column, touched.first, held.first, visitor);
            visitor.all(starts[held.first], starts[held.last]);
            visit_rim(cap, column, held.last, touched.last, visitor);
        }
    }
}

Hit_map::Rims Hit_map::rims(double half_angle_rad) const {
    return {half_angle_rad, reach_rad(1.0 / static_cast<double>(grid_.side()))};
}

template <typename Visitor> void Hit_map::visit(const Vector &direction, const Rims &rims, Visitor &visitor) const {
    for (unsigned face = 0; face < cube_faces; ++face) {
        visit_face(direction, rims, face, visitor);
    }
}

Tally Hit_map::sum(const Vector &direction, const Rims &rims) const {
    Summing summing(*this);
    visit(direction, rims, summing);
    return summing.tally;
}

Estimate Hit_map::fixed(const Vector &direction, double half_angle_rad) const {
    Tally const tally = sum(direction, rims(half_angle_rad));
    return estimate(tally.weight, tally.square, tally.hits, photons_, half_angle_rad);
}

std::vector<Estimate> Hit_map::fixed(std::span<const Vector> directions, double half_angle_rad,
                                     unsigned threads) const {
    Rims const same = rims(half_angle_rad);
    std::vector<Estimate> result(directions.size());
    for_neighbours(directions, threads, [&](std::size_t i) {
        Tally const tally = sum(directions[i], same);
        result[i] = estimate(tally.weight, tally.square, tally.hits, photons_, half_angle_rad);
    });
    return result;
}

Aperture_sums Hit_map::sums(std::span<const Vector> directions, double half_angle_rad, unsigned threads) const {
    Rims const same = rims(half_angle_rad);
    Aperture_sums result(directions.size());
    for_neighbours(directions, threads, [&](std::size_t i) { result.add(i, sum(directions[i], same)); });
    return result;
}

// A cap that holds at least the bandwidth, and hardly more than twice that if the light is smooth enough. The most
// holds enough.
double Hit_map::enclosing_half_angle(const Vector &direction, std::uint32_t bandwidth, double most_rad) const {
    constexpr int most_tries = 24;
    double const wanted = 1.4 * bandwidth;
    double low = 0.0;
    double high = most_rad;
    double next = most_rad * std::sqrt(std::min(1.0, wanted / static_cast<double>(hits_.size())));
    for (int i = 0; i < most_tries; ++i) {
        std::uint64_t const hits = sum(direction, rims(next)).hits;
        (hits < bandwidth ? low : high) = next;
        if (hits >= bandwidth && hits <= 2ULL * bandwidth) {
            break;
        }
        // Hits go with the square of the angle.
        next *= std::sqrt(wanted / static_cast<double>(std::max<std::uint64_t>(hits, 1)));
        if (next <= low || next >= high) {
            next = 0.5 * (low + high);
        }
    }
    return high;
}

Estimate Hit_map::nearest(const Vector &direction, std::uint32_t bandwidth, double most_half_angle_rad) const {
    Estimate const widest = fixed(direction, most_half_angle_rad);
    if (widest.hits < bandwidth) {
        return widest;
    }
    double const enclosing = enclosing_half_angle(direction, bandwidth, most_half_angle_rad);
    Rims const same = rims(enclosing);
    Gathering gathering(*this, direction, same.aperture);
    visit(direction, same, gathering);
    std::vector<Gathering::Near> &near = gathering.near;
    auto const last = near.begin() + (static_cast<std::ptrdiff_t>(bandwidth) - 1);
    std::nth_element(near.begin(), last, near.end(),
                     [](const auto &a, const auto &b) { return a.cosine2 > b.cosine2; });
    double const cosine2 = last->cosine2;
    Tally tally; // with all that are as far as the last, lest the order decide
    for (const Gathering::Near &hit : near) {
        if (hit.cosine2 >= cosine2) {
            tally += {hit.weight, whole_square(hit.weight), 1};
        }
    }
    double const sine = std::sqrt(std::max(0.0, 1.0 - std::abs(cosine2)));
    double const cosine = std::copysign(std::sqrt(std::abs(cosine2)), cosine2);
    // No narrower than places are known.
    double const half_angle_rad = std::max(arc_tangent(sine, cosine), 1e-8);
    Estimate result = estimate(tally.weight, tally.square, tally.hits, photons_, half_angle_rad);
    double const k = static_cast<double>(tally.hits);
    result.dsf_per_sr *= (k - 1.0) / k;
    // The cap's own size varies too: 1 / (k - 2) in all where weights are equal.
    double const per_hit = weight_unit * static_cast<double>(tally.weight);
    double const spread = weight_unit * static_cast<double>(tally.square) / (per_hit * per_hit);
    result.standard_error_per_sr = result.dsf_per_sr * (k > 2.0 ? std::sqrt(spread * k / (k - 2.0)) : 1.0);
    return result;
}

std::vector<Estimate> Hit_map::nearest(std::span<const Vector> directions, std::uint32_t bandwidth,
                                       double most_half_angle_rad, unsigned threads) const {
    std::vector<Estimate> result(directions.size());
    for_neighbours(directions, threads,
                   [&](std::size_t i) { result[i] = nearest(directions[i], bandwidth, most_half_angle_rad); });
    return result;
}

std::size_t Hit_map::bytes() const {
    return hits_.capacity() * sizeof(Stored_hit) + running_.capacity() * sizeof(Running) +
           grid_.starts.capacity() * sizeof(std::uint32_t);
}

} // namespace gonio::sim
