// locator.cpp: a walk over triangles towards a direction; many directions along a Hilbert curve, so that walks are
// short.
#include "locator.hpp"

#include <algorithm>
#include <cstddef>
#include <mutex>
#include <utility>

#include "threads.hpp"

namespace gonio::sphere {
namespace {

bool looks_outwards(const Triangulation &hull, Index triangle) {
    const Triangulation::Corners &t = hull.triangles()[triangle];
    const Vec a = hull.points()[t[0]];
    return dot(cross(hull.points()[t[1]] - a, hull.points()[t[2]] - a), a) > 0.0;
}

bool reaches(const Vec &point, const Vec &direction, double reach) {
    return angle_of_chord(length(direction - point)) <= reach;
}

} // namespace

Locator::Locator(std::span<const Vec> unit, std::span<const double> reach, bool cut_at_horizon)
    : cut_at_horizon_(cut_at_horizon) {
    std::mutex guard;
    for_each_part(unit, cut_at_horizon, [&](Part_of_sphere &&sphere) {
        Part part;
        part.reach = reach_of(sphere, {reach, {}});
        if (sphere.hull) {
            part.outwards = 0;
            while (!looks_outwards(*sphere.hull, part.outwards)) {
                ++part.outwards;
            }
        } else {
            order_on_circle(sphere.points, part.axis);
            const auto [e1, e2] = tangents(part.axis);
            for (std::size_t i = 0; i < sphere.points.size(); ++i) {
                if (sphere.stands_for[i] == static_cast<Index>(i)) {
                    part.azimuth.emplace_back(std::atan2(dot(sphere.points[i], e2), dot(sphere.points[i], e1)), i);
                }
            }
            std::sort(part.azimuth.begin(), part.azimuth.end());
        }
        part.sphere = std::move(sphere);
        const std::lock_guard<std::mutex> held(guard);
        parts_.push_back(std::move(part));
    });
}

const Locator::Part *Locator::part_of(const Vec &direction) const {
    const double side = !cut_at_horizon_ ? 0.0 : direction.z >= 0.0 ? 1.0 : -1.0;
    const auto found =
        std::find_if(parts_.begin(), parts_.end(), [&](const Part &part) { return part.sphere.side == side; });
    return found == parts_.end() ? nullptr : &*found;
}

// Points on one circle have no triangles: the nearest one stands for what is within its reach.
Found Locator::on_circle(const Part &part, const Vec &direction) {
    const auto [e1, e2] = tangents(part.axis);
    const std::pair<double, Index> here{std::atan2(dot(direction, e2), dot(direction, e1)), -1};
    const auto after = std::lower_bound(part.azimuth.begin(), part.azimuth.end(), here);
    const Index next = (after == part.azimuth.end() ? part.azimuth.front() : *after).second;
    const Index previous = (after == part.azimuth.begin() ? part.azimuth.back() : *std::prev(after)).second;
    const std::vector<Vec> &points = part.sphere.points;
    const Index nearest = length(points[next] - direction) < length(points[previous] - direction) ? next : previous;
    Found found;
    found.index.fill(part.sphere.number[nearest]);
    found.inside = reaches(points[nearest], direction, part.reach[nearest]);
    found.weight[0] = found.inside ? 1.0 : 0.0;
    return found;
}

// By the volumes over the triangle's edges, which the direction has across from each corner.
Found Locator::weights(const Part &part, Index triangle, const Vec &direction, const std::array<double, 3> &volume) {
    const Triangulation::Corners &t = part.sphere.hull->triangles()[triangle];
    Found found;
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        found.index[k] = part.sphere.number[t[k]];
        found.weight[k] = std::max(volume[k], 0.0);
        sum += found.weight[k];
        found.inside = found.inside || reaches(part.sphere.hull->points()[t[k]], direction, part.reach[t[k]]);
    }
    found.inside = found.inside && sum > 0.0;
    for (double &weight : found.weight) {
        weight = found.inside ? weight / sum : 0.0;
    }
    return found;
}

Found Locator::in_hull(const Part &part, const Vec &direction, Index &last) {
    const Triangulation &hull = *part.sphere.hull;
    const std::vector<Vec> &points = hull.points();
    Found found;
    Index at = last < 0 ? part.outwards : last;
    Index from = -1;
    for (std::size_t step = 0; step < hull.triangles().size(); ++step) {
        const Triangulation::Corners &t = hull.triangles()[at];
        const std::array<Vec, 3> ray = {points[t[0]] - direction, points[t[1]] - direction, points[t[2]] - direction};
        // Six times the volume between the origin, the direction and each edge: negative where the direction is beyond.
        std::array<double, 3> volume{};
        int worst = -1;
        for (int k = 0; k < 3; ++k) {
            volume[k] = dot(cross(ray[(k + 1) % 3], ray[(k + 2) % 3]), direction);
            if (volume[k] < 0.0 && hull.across()[at][k] != from && (worst < 0 || volume[k] < volume[worst])) {
                worst = k;
            }
        }
        // Over the border of what the points surround there is nothing; on it there is.
        const bool at_border = worst >= 0 && !looks_outwards(hull, hull.across()[at][worst]);
        const bool beyond =
            at_border && volume[worst] < -MERGE_RAD * length(ray[(worst + 1) % 3] - ray[(worst + 2) % 3]);
        if (worst < 0 || at_border) {
            last = at;
            return beyond ? found : weights(part, at, direction, volume);
        }
        from = at;
        at = hull.across()[at][worst];
    }
    return found;
}

std::vector<Found> Locator::at(std::span<const Vec> directions) const {
    std::vector<Found> result(directions.size());
    const std::vector<Index> order = hilbert_order(directions);
    in_threads(order.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<Index> last(parts_.size(), -1);
        for (std::size_t k = begin; k < end; ++k) {
            const Vec &direction = directions[order[k]];
            const Part *part = part_of(direction);
            if (part != nullptr) {
                result[order[k]] = part->sphere.hull ? in_hull(*part, direction, last[part - parts_.data()])
                                                     : on_circle(*part, direction);
            }
        }
    });
    return result;
}

} // namespace gonio::sphere
