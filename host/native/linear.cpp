// linear.cpp: thirds of triangles, and fans of those that lie on one circle.
#include "linear.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "voronoi.hpp"

namespace gonio::sphere {
namespace {

// Height over the plane of three points at which a fourth lies on their circle: rounding to the grid moves points by
// 8e-13.
constexpr double ON_CIRCLE = 1e-11;

// A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30, 125 (1983); from differences, which keep the digits of
// small triangles.
double triangle_area(const Vec &a, const Vec &b, const Vec &c) {
    const double triple = std::fabs(dot(a, cross(b - a, c - a)));
    return 2.0 * std::atan2(triple, 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
}

} // namespace

Linear_less_voronoi::Linear_less_voronoi(const Triangulation &hull, std::span<const double> cos_reach, Index real)
    : hull_(hull), cos_reach_(cos_reach), real_(real), covered_(hull.triangles().size(), 0),
      extra_(hull.points().size(), 0.0) {}

void Linear_less_voronoi::add(Index triangle, const std::array<double, 3> &share, double cos_radius, double size) {
    constexpr double HALF_SPHERE = 1e-6;
    const Triangulation::Corners &t = hull_.triangles()[triangle];
    for (const Index corner : t) {
        if (corner >= real_ || cos_radius < std::max(cos_reach_[corner], HALF_SPHERE)) {
            return;
        }
    }
    covered_[triangle] = 1;
    const double third = (share[0] + share[1] + share[2]) / 3.0;
    for (int k = 0; k < 3; ++k) {
        extra_[t[k]] += third - share[k];
    }
    const std::vector<Vec> &points = hull_.points();
    const Vec normal = cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
    for (const Index next : hull_.across()[triangle]) {
        for (const Index corner : hull_.triangles()[next]) {
            if (corner != t[0] && corner != t[1] && corner != t[2] &&
                std::fabs(dot(normal, points[corner] - points[t[0]])) < ON_CIRCLE * size) {
                ties_.emplace_back(triangle, next);
            }
        }
    }
}

std::vector<double> Linear_less_voronoi::finished() {
    std::erase_if(ties_, [&](const auto &tie) { return covered_[tie.second] == 0; });
    if (!ties_.empty()) {
        fans();
    }
    return std::move(extra_);
}

// Joins triangles across ties to faces.
void Linear_less_voronoi::fans() {
    face_.resize(hull_.triangles().size());
    std::iota(face_.begin(), face_.end(), 0);
    const auto root = [&](Index one) {
        while (face_[one] != one) {
            face_[one] = face_[face_[one]];
            one = face_[one];
        }
        return one;
    };
    for (const auto &[one, other] : ties_) {
        face_[root(one)] = root(other);
    }
    std::vector<std::pair<Index, Index>> members;
    members.reserve(2 * ties_.size());
    for (const auto &[one, other] : ties_) {
        members.emplace_back(root(one), one);
        members.emplace_back(root(one), other);
    }
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    for (const auto &[face, triangle] : members) {
        face_[triangle] = face;
    }
    for (std::size_t begin = 0; begin < members.size();) {
        std::size_t end = begin;
        while (end < members.size() && members[end].first == members[begin].first) {
            ++end;
        }
        fan(std::span(members).subspan(begin, end - begin));
        begin = end;
    }
}

// Takes the thirds of a face's triangles back and shares it by a fan about its middle.
void Linear_less_voronoi::fan(std::span<const std::pair<Index, Index>> face) {
    const std::vector<Vec> &points = hull_.points();
    std::vector<std::pair<Index, Index>> border;
    Vec middle;
    double whole = 0.0;
    for (const auto &[number, triangle] : face) {
        const Triangulation::Corners &t = hull_.triangles()[triangle];
        const double area = area_of(triangle);
        whole += area;
        for (int e = 0; e < 3; ++e) {
            extra_[t[e]] -= area / 3.0;
            if (face_[hull_.across()[triangle][e]] != number) {
                border.emplace_back(t[(e + 1) % 3], t[(e + 2) % 3]);
                middle += points[t[(e + 1) % 3]] + points[t[(e + 2) % 3]];
            }
        }
    }
    middle = normalised(middle);
    double sum = 0.0;
    for (const auto &[from, to] : border) {
        sum += triangle_area(middle, points[from], points[to]);
    }
    const double mean = whole / (3.0 * static_cast<double>(border.size()));
    for (const auto &[from, to] : border) {
        // Nearly cocircular corners may leave a middle that the face does not hold whole: keep its area.
        const double third = triangle_area(middle, points[from], points[to]) * (whole / sum) / 3.0;
        extra_[from] += third + mean;
        extra_[to] += third;
    }
}

double Linear_less_voronoi::area_of(Index triangle) const {
    const Triangulation::Corners &t = hull_.triangles()[triangle];
    return triangle_area(hull_.points()[t[0]], hull_.points()[t[1]], hull_.points()[t[2]]);
}

} // namespace gonio::sphere
