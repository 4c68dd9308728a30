// reach.cpp: how far points own directions where fine tracks meet coarse ones.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "parts.hpp"

namespace gonio::sphere {
namespace {

constexpr double ROUNDING = 1.0 + 1e-6; // a place at the end of the reach is within it

// A place equally far from three points that not all of them reach.
struct Place {
    Triangulation::Corners owners;
    double distance;
};

// Gives each point's reach to its neighbours within it; `mine` are the points that give and take.
void give(const Triangulation &hull, const std::vector<char> &mine, std::vector<double> &reach) {
    const std::vector<double> own = reach;
    const std::vector<Vec> &points = hull.points();
    for (const Triangulation::Corners &t : hull.triangles()) {
        for (int e = 0; e < 3; ++e) { // every edge comes twice, once in each sense
            const Index from = t[e];
            const Index to = t[(e + 1) % 3];
            if (own[from] > reach[to] && mine[from] != 0 && mine[to] != 0 &&
                angle_of_chord(length(points[from] - points[to])) <= own[from]) {
                reach[to] = own[from];
            }
        }
    }
}

std::vector<Place> places_in_doubt(const Triangulation &hull, const std::vector<char> &mine,
                                   const std::vector<double> &reach) {
    std::vector<Place> places;
    for (const Triangulation::Corners &t : hull.triangles()) {
        if (mine[t[0]] == 0 || mine[t[1]] == 0 || mine[t[2]] == 0) {
            continue;
        }
        double size = 0.0;
        const Vec &corner = hull.points()[t[0]];
        const Vec centre = circumcentre(corner, hull.points()[t[1]], hull.points()[t[2]], size);
        const double distance = angle_of_chord(length(centre - corner)) * ROUNDING;
        if (distance > std::min({reach[t[0]], reach[t[1]], reach[t[2]]})) {
            places.push_back({t, distance});
        }
    }
    return places;
}

} // namespace

std::vector<double> reach_of(const Part_of_sphere &part, const Reach &reach) {
    std::vector<double> result(part.points.size(), 0.0);
    std::vector<char> mine(part.points.size(), 0);
    for (std::size_t i = 0; i < result.size(); ++i) {
        double &widest = result[part.stands_for[i]];
        widest = std::max(widest, reach.rad[part.number[i]]);
        if (!reach.shared.empty() && reach.shared[part.number[i]]) {
            mine[part.stands_for[i]] = 1;
        }
    }
    if (reach.shared.empty() || !part.hull) {
        return result;
    }
    give(*part.hull, mine, result);
    std::vector<Place> places = places_in_doubt(*part.hull, mine, result);
    for (bool changed = true; changed;) {
        const std::size_t before = places.size();
        std::erase_if(places, [&](const Place &one) {
            const bool reached = std::any_of(one.owners.begin(), one.owners.end(),
                                             [&](Index owner) { return result[owner] >= one.distance; });
            for (const Index owner : one.owners) {
                result[owner] = reached ? std::max(result[owner], one.distance) : result[owner];
            }
            return reached;
        });
        changed = places.size() < before;
    }
    return result;
}

} // namespace gonio::sphere
