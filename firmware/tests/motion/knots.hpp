// knots.hpp: knots and limits that the motion tests share: closed-form curves sampled into knots.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

extern "C" {
#include "path.h"
}

namespace motion_test {

inline constexpr double counts_per_deg = 10000.0 / 9.0;

// Position, velocity and acceleration of the four axes at a time.
struct Curve_point {
    std::array<double, 4> position, velocity, acceleration;
};
using Curve = std::function<Curve_point(double time_s)>;

inline gn_knot knot_of(const Curve_point &point, std::int64_t time_ns) {
    gn_knot knot{};
    knot.time_ns = time_ns;
    for (std::size_t axis = 0; axis < 4; axis++) {
        knot.position_counts[axis] = point.position[axis];
        knot.velocity_counts_per_s[axis] = point.velocity[axis];
        knot.acceleration_counts_per_s2[axis] = point.acceleration[axis];
    }
    return knot;
}

inline gn_knot rest(std::int64_t time_ns, std::array<double, 4> position) {
    return knot_of({position, {}, {}}, time_ns);
}

// A law of path time that rises from 0 to 1 in rate over `ramp_s` with zero first and second derivative at both ends:
// s(t) = ramp (u^6 - 3 u^5 + 5/2 u^4), u = t / ramp.
struct Ramp {
    double s, ds, dds;
};
inline Ramp ramp(double t, double ramp_s) {
    double const u = t / ramp_s;
    if (u >= 1.0) {
        return {0.5 * ramp_s + (t - ramp_s), 1.0, 0.0};
    }
    double const u2 = u * u;
    return {ramp_s * u2 * u2 * (u2 - 3.0 * u + 2.5), u2 * u * (6.0 * u2 - 15.0 * u + 10.0),
            (30.0 * u2 * u2 - 60.0 * u2 * u + 30.0 * u2) / ramp_s};
}

// All axes on sinusoids of different phase and period, 30 degrees/s at most, starting and ending at rest.
inline Curve_point sinusoids(double time_s, double duration_s) {
    double const ramp_s = 2.0;
    bool const ending = time_s > 0.5 * duration_s;
    Ramp law = ramp(ending ? duration_s - time_s : time_s, ramp_s);
    if (ending) { // run the same law backwards from the end
        law = {duration_s - ramp_s - law.s, law.ds, -law.dds};
    }
    Curve_point point{};
    for (std::size_t axis = 0; axis < 4; axis++) {
        double const amplitude = 25.0 * counts_per_deg;
        double const w = 0.9 + 0.08 * static_cast<double>(axis);
        double const phase = 0.7 * static_cast<double>(axis);
        double const angle = w * law.s + phase;
        double const velocity = amplitude * w * std::cos(angle);
        point.position[axis] = amplitude * std::sin(angle);
        point.velocity[axis] = velocity * law.ds;
        point.acceleration[axis] = -amplitude * w * w * std::sin(angle) * law.ds * law.ds + velocity * law.dds;
    }
    return point;
}

inline std::vector<gn_knot> sinusoid_knots(std::size_t count, std::int64_t spacing_ns) {
    std::vector<gn_knot> knots;
    double const duration_s = static_cast<double>(count - 1) * static_cast<double>(spacing_ns) * 1e-9;
    for (std::size_t i = 0; i < count; i++) {
        std::int64_t const time_ns = static_cast<std::int64_t>(i) * spacing_ns;
        knots.push_back(knot_of(sinusoids(static_cast<double>(time_ns) * 1e-9, duration_s), time_ns));
    }
    return knots;
}

inline gn_axis_limits limits_deg(double min_deg, double max_deg, double velocity, double acceleration) {
    return {min_deg * counts_per_deg, max_deg * counts_per_deg, velocity * counts_per_deg,
            acceleration * counts_per_deg, nullptr};
}

// A path with the reference instrument's speeds and one sentence of room for refusals.
struct Bench {
    gn_path path{};
    char why[200] = "";
    std::array<double, 4> target{};
    bool underrun = false;
    std::size_t sent = 0;

    Bench() {
        gn_path_init(&path);
        for (std::uint32_t axis = 0; axis < 4; axis++) {
            gn_axis_limits const limits = limits_deg(-85.0, 85.0, 30.0, 60.0);
            gn_path_set_limits(&path, axis, &limits);
        }
    }
    bool begin(const std::vector<gn_knot> &knots) {
        sent = 0;
        return gn_path_begin(&path, 1, static_cast<std::uint32_t>(knots.size()), why, sizeof why);
    }
    bool push(std::uint32_t number, const gn_knot &knot, const std::array<double, 4> &standing) {
        return gn_path_push(&path, number, &knot, standing.data(), why, sizeof why);
    }
    // Send all that credit (and `at_most`) allows.
    bool feed(const std::vector<gn_knot> &knots, std::size_t at_most = SIZE_MAX) {
        std::array<double, 4> standing{};
        for (std::size_t axis = 0; axis < 4; axis++) {
            standing[axis] = knots.front().position_counts[axis];
        }
        while (sent < knots.size() && sent < at_most && sent < gn_path_credit(&path)) {
            if (!push(static_cast<std::uint32_t>(sent), knots[sent], standing)) {
                return false;
            }
            sent++;
        }
        return true;
    }
    void step(std::int64_t dt_ns = 2'000'000) { gn_path_step(&path, dt_ns, target.data(), &underrun); }
    // Begin a path of these knots, at rest at the first, and push the rest: the sentence of the refusal, or "".
    std::string refusal(const std::vector<gn_knot> &knots) { return begin(knots) && feed(knots) ? "" : why; }
};

} // namespace motion_test
