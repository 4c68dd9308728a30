// parts.cpp: hemispheres, mirror images at the horizon, repeated points.
#include "parts.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <thread>
#include <utility>

namespace gonio::sphere {
namespace {

Vec mirrored(const Vec &v) {
    return {v.x, v.y, -v.z};
}

// Points whose cells reach over the horizon: only their own images can cut them there, and no image takes anything from
// a cell on this side.
std::vector<Index> over_the_horizon(const Triangulation &hull, double side) {
    constexpr double TOUCHES = -1e-12;
    std::vector<char> over(hull.points().size(), 0);
    for (const Triangulation::Corners &t : hull.triangles()) {
        double size = 0.0;
        const Vec centre = circumcentre(hull.points()[t[0]], hull.points()[t[1]], hull.points()[t[2]], size);
        if (side * centre.z < TOUCHES) {
            over[t[0]] = over[t[1]] = over[t[2]] = 1;
        }
    }
    std::vector<Index> result;
    for (std::size_t i = 0; i < over.size(); ++i) {
        if (over[i] != 0) {
            result.push_back(static_cast<Index>(i));
        }
    }
    return result;
}

// Points nearer together than MERGE_RAD along their circle are one.
std::vector<Index> merged_on_circle(std::span<const Vec> points) {
    std::vector<Index> stands_for(points.size());
    Vec axis;
    Index last = -1;
    for (const Index one : order_on_circle(points, axis)) {
        if (last < 0 || length(points[one] - points[last]) >= MERGE_RAD) {
            last = one;
        }
        stands_for[one] = last;
    }
    return stands_for;
}

Part_of_sphere part_of(std::span<const Vec> unit, std::vector<Index> chosen, double side) {
    Part_of_sphere part;
    part.side = side;
    std::vector<Vec> own(chosen.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        own[i] = unit[chosen[i]];
        if (side != 0.0) {
            own[i].z = side * std::max(side * own[i].z, MERGE_RAD); // apart from its image it is not merged with it
        }
    }
    std::vector<Index> order;
    part.points = ordered_on_grid(own, order);
    part.real = static_cast<Index>(order.size());
    part.number.resize(order.size());
    std::transform(order.begin(), order.end(), part.number.begin(), [&](Index one) { return chosen[one]; });
    part.hull = Triangulation::of(part.points);
    if (side != 0.0) {
        std::vector<Index> images;
        if (part.hull) {
            images = over_the_horizon(*part.hull, side);
        } else {
            images.resize(part.points.size());
            for (std::size_t i = 0; i < images.size(); ++i) {
                images[i] = static_cast<Index>(i);
            }
        }
        for (const Index one : images) {
            part.points.push_back(mirrored(part.points[one]));
            part.number.push_back(part.number[one]);
            if (part.hull) {
                part.hull->add(part.points.back());
            }
        }
        if (!part.hull) {
            part.hull = Triangulation::of(part.points);
        }
    }
    part.stands_for = part.hull ? part.hull->stands_for() : merged_on_circle(part.points);
    return part;
}

Cells cells_of_part(const Part_of_sphere &part, std::span<const double> reach) {
    if (part.hull) {
        return cells_of(*part.hull, reach, part.real);
    }
    std::vector<Index> distinct;
    std::vector<Vec> points;
    std::vector<double> own_reach;
    for (std::size_t i = 0; i < part.points.size(); ++i) {
        if (part.stands_for[i] == static_cast<Index>(i)) {
            distinct.push_back(static_cast<Index>(i));
            points.push_back(part.points[i]);
            own_reach.push_back(reach[i]);
        }
    }
    const Cells found = cells_on_circle(points, own_reach);
    const std::size_t n = part.points.size();
    Cells cells{std::vector<double>(n), std::vector<double>(n), std::vector<Vec>(n)};
    for (std::size_t k = 0; k < distinct.size(); ++k) {
        cells.solid[distinct[k]] = found.solid[k];
        cells.linear[distinct[k]] = found.linear[k];
        cells.moment[distinct[k]] = found.moment[k];
    }
    return cells;
}

} // namespace

void for_each_part(std::span<const Vec> unit, bool cut_at_horizon, const std::function<void(Part_of_sphere &&)> &use) {
    std::vector<Index> up;
    std::vector<Index> down;
    for (std::size_t i = 0; i < unit.size(); ++i) {
        (!cut_at_horizon || unit[i].z >= 0.0 ? up : down).push_back(static_cast<Index>(i));
    }
    std::exception_ptr failed;
    std::thread below;
    if (!down.empty()) {
        below = std::thread([&] {
            try {
                use(part_of(unit, std::move(down), -1.0));
            } catch (...) {
                failed = std::current_exception();
            }
        });
    }
    std::exception_ptr failed_here;
    try {
        if (!up.empty()) {
            use(part_of(unit, std::move(up), cut_at_horizon ? 1.0 : 0.0));
        }
    } catch (...) {
        failed_here = std::current_exception();
    }
    if (below.joinable()) {
        below.join();
    }
    for (const std::exception_ptr &one : {failed_here, failed}) {
        if (one) {
            std::rethrow_exception(one);
        }
    }
}

std::vector<double> shared_reach(std::span<const Vec> unit, const Reach &reach) {
    std::vector<double> result(unit.size());
    for_each_part(unit, true, [&](const Part_of_sphere &part) {
        const std::vector<double> found = reach_of(part, reach);
        for (Index i = 0; i < part.real; ++i) {
            result[part.number[i]] = found[part.stands_for[i]];
        }
    });
    return result;
}

Cells cells_of_points(std::span<const Vec> unit, const Reach &reach, bool cut_at_horizon) {
    const std::size_t n = unit.size();
    Cells all{std::vector<double>(n), std::vector<double>(n), std::vector<Vec>(n)};
    for_each_part(unit, cut_at_horizon, [&](Part_of_sphere &&part) {
        const Cells found = cells_of_part(part, reach_of(part, reach));
        std::vector<Index> sharers(part.points.size(), 0);
        for (Index i = 0; i < part.real; ++i) {
            ++sharers[part.stands_for[i]];
        }
        for (Index i = 0; i < part.real; ++i) {
            const Index own = part.stands_for[i];
            const double share = 1.0 / sharers[own];
            const Index number = part.number[i];
            all.solid[number] = share * found.solid[own];
            all.linear[number] = share * found.linear[own];
            all.moment[number] = share * found.moment[own];
        }
    });
    return all;
}

std::vector<std::int64_t> edges_of(const Part_of_sphere &part) {
    std::vector<std::int64_t> pairs;
    const auto put = [&](Index a, Index b) {
        pairs.push_back(part.number[a]);
        pairs.push_back(part.number[b]);
    };
    if (part.hull) {
        const auto &triangles = part.hull->triangles();
        pairs.reserve(3 * triangles.size());
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            for (int e = 0; e < 3; ++e) {
                if (part.hull->across()[t][e] > static_cast<Index>(t)) {
                    put(triangles[t][(e + 1) % 3], triangles[t][(e + 2) % 3]);
                }
            }
        }
        return pairs;
    }
    std::vector<Index> distinct;
    Vec axis;
    for (const Index one : order_on_circle(part.points, axis)) {
        if (part.stands_for[one] == one) {
            distinct.push_back(one);
        }
    }
    for (std::size_t k = 0; k + 1 < distinct.size(); ++k) {
        put(distinct[k], distinct[k + 1]);
    }
    if (distinct.size() > 2) {
        put(distinct.back(), distinct.front());
    }
    return pairs;
}

} // namespace gonio::sphere
