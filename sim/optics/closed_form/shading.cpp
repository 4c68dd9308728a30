// shading.cpp: two overlapping circles, beam and head.
#include "shading.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gonio::sim {

double overlap_area(double radius_a, double radius_b, double distance) {
    if (distance >= radius_a + radius_b) {
        return 0.0;
    }
    double const smaller = std::min(radius_a, radius_b);
    if (distance <= std::abs(radius_a - radius_b)) {
        return std::numbers::pi * smaller * smaller;
    }
    // Two circular segments: each a sector less its triangle.
    auto const segment = [&](double radius, double other) {
        double const chord_distance = (distance * distance + radius * radius - other * other) / (2.0 * distance);
        double const cosine = std::clamp(chord_distance / radius, -1.0, 1.0);
        return radius * radius * (std::acos(cosine) - cosine * std::sqrt(1.0 - cosine * cosine));
    };
    return segment(radius_a, radius_b) + segment(radius_b, radius_a);
}

double Head::transmitted(const Vec3 &incident, const Vec3 &outgoing) const {
    double const cosine = incident[0] * outgoing[0] + incident[1] * outgoing[1] + incident[2] * outgoing[2];
    if (cosine <= 0.0) {
        return 1.0;
    }
    double const distance_mm = arm_radius_mm * std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    double const beam_radius_mm = 0.5 * beam_diameter_mm;
    double const blocked = overlap_area(beam_radius_mm, 0.5 * head_diameter_mm, distance_mm);
    return 1.0 - blocked / (std::numbers::pi * beam_radius_mm * beam_radius_mm);
}

} // namespace gonio::sim
