// kinematics.cpp: the axes' turns, applied with Rodrigues' formula.
#include "kinematics.hpp"

#include <cmath>
#include <numbers>

namespace gonio::sim {
namespace {

Vec3 turn(const Vec3 &v, const Vec3 &k, double sine, double cosine) {
    double const along = (k[0] * v[0] + k[1] * v[1] + k[2] * v[2]) * (1.0 - cosine);
    return {v[0] * cosine + (k[1] * v[2] - k[2] * v[1]) * sine + k[0] * along,
            v[1] * cosine + (k[2] * v[0] - k[0] * v[2]) * sine + k[1] * along,
            v[2] * cosine + (k[0] * v[1] - k[1] * v[0]) * sine + k[2] * along};
}

} // namespace

Kinematics::Kinematics(const std::array<Axis_settings, axis_count> &axes) {
    for (std::size_t i = 0; i < axis_count; ++i) {
        Vec3 const &v = axes.at(i).vector;
        double const length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        turns_.at(i) = {{v[0] / length, v[1] / length, v[2] / length}, axes.at(i).carries_sample};
    }
}

Directions Kinematics::directions(const std::array<double, axis_count> &q_deg) const {
    std::array<double, axis_count> sine{};
    std::array<double, axis_count> cosine{};
    for (std::size_t i = 0; i < axis_count; ++i) {
        double const q = q_deg.at(i) * std::numbers::pi / 180.0;
        sine.at(i) = std::sin(q);
        cosine.at(i) = std::cos(q);
    }
    // The detector in the lab: the axis nearest to it turns it first.
    Vec3 detector = {0.0, 0.0, 1.0};
    for (std::size_t i = axis_count; i-- > 0;) {
        if (!turns_.at(i).carries_sample) {
            detector = turn(detector, turns_.at(i).vector, sine.at(i), cosine.at(i));
        }
    }
    // Lab to sample: the sample's turns undone, the outermost first.
    Vec3 source = {0.0, 0.0, 1.0};
    Vec3 up = {0.0, 1.0, 0.0};
    for (std::size_t i = 0; i < axis_count; ++i) {
        if (turns_.at(i).carries_sample) {
            source = turn(source, turns_.at(i).vector, -sine.at(i), cosine.at(i));
            detector = turn(detector, turns_.at(i).vector, -sine.at(i), cosine.at(i));
            up = turn(up, turns_.at(i).vector, -sine.at(i), cosine.at(i));
        }
    }
    return {source, detector, up};
}

} // namespace gonio::sim
