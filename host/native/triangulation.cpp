// triangulation.cpp: incremental convex hull after A. Bowyer and D. F. Watson (Comput. J. 24, 1981), with exact
// decisions; ties leave what is there.
#include "triangulation.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace gonio::sphere {
namespace {

// Four points of a circle, rounded to the grid, are no higher over the plane of each other than this, nor than this
// share of the squared extent.
constexpr double FLAT = 1e-11;
constexpr double FLAT_SHARE = 1e-9;

// Points per round of insertion: the first round has about this many, each further one four times as many
// (N. Amenta, S. Choi and G. Rote, "Incremental constructions con BRIO", 2003), so that no order is a bad one.
constexpr std::size_t FIRST_ROUND = 512;

int round_of(std::size_t number, int rounds) {
    std::uint64_t hash = (number + 1) * 0x9E3779B97F4A7C15ULL;
    hash ^= hash >> 29;
    hash *= 0xBF58476D1CE4E5B9ULL;
    hash ^= hash >> 32;
    int late = rounds - 1;
    while (late > 0 && (hash & 3U) == 0) {
        hash >>= 2;
        --late;
    }
    return late;
}

double squared_distance(const Vec &a, const Vec &b) {
    const Vec d = a - b;
    return dot(d, d);
}

} // namespace

std::vector<Vec> ordered_on_grid(std::span<const Vec> unit, std::vector<Index> &order) {
    order = hilbert_order(unit);
    std::vector<Vec> points(unit.size());
    for (std::size_t i = 0; i < unit.size(); ++i) {
        points[i] = on_grid(unit[order[i]]);
    }
    return points;
}

std::optional<Triangulation> Triangulation::of(std::vector<Vec> points) {
    Triangulation result(std::move(points));
    if (!result.begin()) {
        return std::nullopt;
    }
    const std::size_t n = result.points_.size();
    result.triangles_.reserve(2 * n);
    result.across_.reserve(2 * n);
    result.dug_.reserve(2 * n);
    int rounds = 1;
    for (std::size_t left = n; left > FIRST_ROUND; left /= 4) {
        ++rounds;
    }
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t i = 0; i < n; ++i) {
            const auto index = static_cast<Index>(i);
            if (round_of(i, rounds) == round &&
                std::find(result.first_.begin(), result.first_.end(), index) == result.first_.end()) {
                result.insert(index);
            }
        }
    }
    return result;
}

Index Triangulation::add(const Vec &point) {
    const auto index = static_cast<Index>(points_.size());
    points_.push_back(point);
    stands_for_.push_back(index);
    insert(index);
    return stands_for_[index];
}

bool Triangulation::begin() {
    const std::size_t n = points_.size();
    stands_for_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        stands_for_[i] = static_cast<Index>(i);
    }
    if (n < 4) {
        return false;
    }
    const auto farthest = [&](auto &&measure) {
        std::size_t best = 0;
        double most = -1.0;
        for (std::size_t i = 0; i < n; ++i) {
            const double value = measure(points_[i]);
            if (value > most) {
                most = value;
                best = i;
            }
        }
        return static_cast<Index>(best);
    };
    const Vec a = points_[0];
    const Index second = farthest([&](const Vec &p) { return squared_distance(a, p); });
    const Vec b = points_[second];
    const Index third = farthest([&](const Vec &p) { return length(cross(p - a, b - a)); });
    const Vec c = points_[third];
    const Vec normal = cross(b - a, c - a);
    const Index fourth = farthest([&](const Vec &p) {
        const double near = std::min({squared_distance(a, p), squared_distance(b, p), squared_distance(c, p)});
        return near < MERGE_RAD * MERGE_RAD ? 0.0 : std::fabs(dot(normal, p - a));
    });
    const Vec d = points_[fourth];
    const double area = length(normal);
    const double extent = squared_distance(a, b);
    if (std::min(squared_distance(a, c), squared_distance(b, c)) < MERGE_RAD * MERGE_RAD ||
        std::fabs(dot(normal, d - a)) <= std::max(FLAT, FLAT_SHARE * extent) * area) {
        return false;
    }
    first_ = {0, second, third, fourth};
    if (side_of(a, b, c, d) > 0) { // the fourth is behind the first triangle
        std::swap(first_[1], first_[2]);
    }
    inside_ = on_grid(0.25 * (a + b + c + d));
    const auto [p, q, r, s] = first_;
    triangles_ = {{p, q, r}, {p, s, q}, {q, s, r}, {r, s, p}};
    across_ = {{2, 3, 1}, {2, 0, 3}, {3, 0, 1}, {1, 0, 2}};
    dug_.assign(4, 0);
    return std::all_of(triangles_.begin(), triangles_.end(), [&](const Corners &t) {
        return side_of(points_[t[0]], points_[t[1]], points_[t[2]], inside_) < 0;
    });
}

void Triangulation::insert(Index point) {
    const Vec p = points_[point];
    const Index first = locate(p);
    const Corners &t = triangles_[first];
    if (side_of(points_[t[0]], points_[t[1]], points_[t[2]], p) <= 0 || !dig(first, p)) {
        last_ = first;
        stands_for_[point] = nearest_corner(first, p);
        for (const Border &one : border_) {
            if (squared_distance(points_[one.from], p) < squared_distance(points_[stands_for_[point]], p)) {
                stands_for_[point] = one.from;
            }
        }
    } else {
        fill(point);
    }
    for (const Index one : pit_) {
        dug_[one] = 0;
    }
    pit_.clear();
    border_.clear();
}

// The triangle in whose direction, seen from inside the hull, the point lies: a walk from the last one, across an edge
// that has the point on its far side.
Index Triangulation::locate(const Vec &p) const {
    Index at = last_;
    Index from = -1;
    for (std::size_t step = 0; step < 4 * triangles_.size(); ++step) {
        const Corners &t = triangles_[at];
        const Corners &next = across_[at];
        const int begin = static_cast<int>(step % 3);
        Index to = -1;
        for (int k = 0; k < 3; ++k) {
            const int e = (begin + k) % 3;
            if (next[e] != from && side_of(inside_, points_[t[(e + 1) % 3]], points_[t[(e + 2) % 3]], p) < 0) {
                to = next[e];
                break;
            }
        }
        if (to < 0) {
            return at;
        }
        from = at;
        at = to;
    }
    return at;
}

// Finds all triangles that the point sees, and their border in counter-clockwise order. False where the point is to be
// merged with one of the border.
bool Triangulation::dig(Index first, const Vec &p) {
    constexpr double MERGE = MERGE_RAD * MERGE_RAD;
    pit_.push_back(first);
    dug_[first] = 1;
    looks_ = {{first, 2}, {first, 1}, {first, 0}};
    bool apart = true;
    while (!looks_.empty()) {
        const Look look = looks_.back();
        looks_.pop_back();
        const Index n = across_[look.triangle][look.edge];
        const Corners &next = across_[n];
        const int back = next[0] == look.triangle ? 0 : next[1] == look.triangle ? 1 : 2;
        const Corners &t = triangles_[n];
        if (dug_[n] != 0) { // round a point that the new one would hide
            return false;
        }
        if (side_of(points_[t[0]], points_[t[1]], points_[t[2]], p) > 0) {
            dug_[n] = 1;
            pit_.push_back(n);
            looks_.push_back({n, (back + 2) % 3});
            looks_.push_back({n, (back + 1) % 3});
        } else {
            const Index from = t[(back + 2) % 3];
            border_.push_back({from, t[(back + 1) % 3], n, back});
            apart = apart && squared_distance(points_[from], p) >= MERGE;
        }
    }
    return apart;
}

// Replaces the triangles of the pit by those between its border and the point.
void Triangulation::fill(Index point) {
    const std::size_t count = border_.size();
    while (pit_.size() < count) {
        pit_.push_back(static_cast<Index>(triangles_.size()));
        triangles_.emplace_back();
        across_.emplace_back();
        dug_.push_back(0);
    }
    for (std::size_t k = 0; k < count; ++k) {
        const Border &one = border_[k];
        const Index here = pit_[k];
        triangles_[here] = {one.from, one.to, point};
        across_[here] = {pit_[k + 1 < count ? k + 1 : 0], pit_[k > 0 ? k - 1 : count - 1], one.outside};
        across_[one.outside][one.edge] = here;
    }
    last_ = pit_[0];
}

Index Triangulation::nearest_corner(Index triangle, const Vec &p) const {
    const Corners &t = triangles_[triangle];
    return *std::min_element(t.begin(), t.end(), [&](Index a, Index b) {
        return squared_distance(points_[a], p) < squared_distance(points_[b], p);
    });
}

} // namespace gonio::sphere
