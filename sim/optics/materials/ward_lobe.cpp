// ward_lobe.cpp: drawing, density and albedo of the lobe.
#include "ward_lobe.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "elementary.hpp"

namespace gonio::sim {

Ward_lobe::Ward_lobe(double roughness_x, double roughness_y) : roughness_x_(roughness_x), roughness_y_(roughness_y) {}

Ward_lobe::Drawn Ward_lobe::draw(const Vector &towards, double u, double v) const {
    double const radius = std::sqrt(-logarithm(u));
    Sine_cosine const azimuth = sine_cosine_of_turns(v);
    double const slope_x = roughness_x_ * radius * azimuth.cosine;
    double const slope_y = roughness_y_ * radius * azimuth.sine;
    double const stretch =
        2.0 * (slope_x * towards.x + slope_y * towards.y + towards.z) / (1.0 + slope_x * slope_x + slope_y * slope_y);
    Vector const direction{stretch * slope_x - towards.x, stretch * slope_y - towards.y, stretch - towards.z};
    if (!(direction.z > 0.0)) {
        return {direction, 0.0};
    }
    return {direction, 2.0 * direction.z / (towards.z + direction.z)};
}

double Ward_lobe::dsf_per_sr(const Vector &towards, const Vector &departing) const {
    if (!(departing.z > 0.0)) {
        return 0.0;
    }
    Vector const half = towards + departing; // not a unit vector
    double const square = half.z * half.z;
    double const slope_x = half.x / roughness_x_;
    double const slope_y = half.y / roughness_y_;
    return exponential(-(slope_x * slope_x + slope_y * slope_y) / square) * dot(half, half) * departing.z *
           std::numbers::inv_pi / (roughness_x_ * roughness_y_ * square * square);
}

// Over the facets' slopes in polar coordinates: with r = slope, s = component of `towards` along its azimuth, the light
// stays above the surface up to r = (s + sqrt(s^2 + z^2)) / z, so that nothing but smooth functions is integrated.
double Ward_lobe::albedo(const Vector &towards) const {
    constexpr int azimuths = 720;
    constexpr int panels = 8;
    // Gauss-Legendre of 4 points on (0, 1).
    constexpr std::array<double, 4> nodes{0.06943184420297371, 0.33000947820757187, 0.66999052179242813,
                                          0.93056815579702629};
    constexpr std::array<double, 4> weights{0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                            0.17392742256872693};
    double sum = 0.0;
    for (int i = 0; i < azimuths; ++i) {
        Sine_cosine const azimuth = sine_cosine_of_turns((i + 0.5) / azimuths);
        double const x = roughness_x_ * azimuth.cosine;
        double const y = roughness_y_ * azimuth.sine;
        double const width = std::sqrt(x * x + y * y);
        double const along = (x * towards.x + y * towards.y) / width;
        double const root = std::sqrt(along * along + towards.z * towards.z);
        double const steepest = along > 0.0 ? (along + root) / towards.z : towards.z / (root - along);
        double const end = std::min(steepest / width, 6.0);
        double const panel = end / panels;
        for (int k = 0; k < panels; ++k) {
            for (std::size_t node = 0; node < nodes.size(); ++node) {
                double const radius = panel * (k + nodes.at(node));
                double const slope = width * radius;
                double const departing_z = 2.0 * (slope * along + towards.z) / (1.0 + slope * slope) - towards.z;
                double const weight = 2.0 * departing_z / (towards.z + departing_z);
                sum += weights.at(node) * panel * 2.0 * radius * exponential(-radius * radius) * weight;
            }
        }
    }
    return sum / azimuths;
}

} // namespace gonio::sim
