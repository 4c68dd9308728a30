// bench_paths.cpp: set-up and paths of the in-process host.
#include "bench_paths.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gonio::sim {
namespace {

constexpr std::array<double, axis_count> centre_deg = {90.0, 180.0, 0.0, 2.0};
constexpr std::array<double, axis_count> pace_rad_per_s = {1.0, 1.3, 1.7, 0.7};
constexpr double speed_share = 0.93; // of each axis's limit
constexpr double ramp_s = 3.0;
constexpr double knot_s = 0.05;

} // namespace

gonio_Request configure_request(const Instrument &instrument) {
    const Cycle &cycle = instrument.cycle;
    gonio_Request request = gonio_Request_init_zero;
    request.which_body = gonio_Request_configure_tag;
    gonio_Configure &c = request.body.configure;
    c.axis_count = axis_count;
    c.sync_period_us = cycle.sync_period_us;
    c.sync_window_us = cycle.sync_window_us;
    c.firmware_heartbeat_ms = cycle.firmware_heartbeat_ms;
    c.drive_heartbeat_ms = cycle.drive_heartbeat_ms;
    c.heartbeat_timeout_ms = cycle.heartbeat_timeout_ms;
    c.rpdo_deadline_syncs = cycle.rpdo_deadline_syncs;
    c.sdo_timeout_ms = cycle.sdo_timeout_ms;
    c.boot_timeout_ms = cycle.boot_timeout_ms;
    c.expiry_ms = cycle.expiry_ms;
    c.sample_period_us = cycle.sample_period_us;
    c.samples_per_strobe = cycle.samples_per_strobe;
    c.clock_settle_ms = cycle.clock_settle_ms;
    c.edge_tolerance_percent = cycle.edge_tolerance_percent;
    return request;
}

gonio_Request axis_request(const Instrument &instrument, std::size_t axis) {
    const Axis_settings &from = instrument.axes.at(axis);
    double const counts = std::abs(from.counts_per_deg);
    auto const in_counts = [&](double deg) { return static_cast<std::uint32_t>(std::lround(counts * deg)); };
    gonio_Request request = gonio_Request_init_zero;
    request.which_body = gonio_Request_configure_axis_tag;
    gonio_AxisConfig &c = request.body.configure_axis;
    c.axis = static_cast<std::uint32_t>(axis);
    std::strncpy(c.name, from.name.c_str(), sizeof c.name - 1);
    c.node = from.node;
    c.counts_per_deg = from.counts_per_deg;
    c.min_counts = std::min(from.min_deg * from.counts_per_deg, from.max_deg * from.counts_per_deg);
    c.max_counts = std::max(from.min_deg * from.counts_per_deg, from.max_deg * from.counts_per_deg);
    c.max_velocity_counts_per_s = counts * from.max_velocity_deg_per_s;
    c.max_acceleration_counts_per_s2 = counts * from.max_acceleration_deg_per_s2;
    c.homing_method = from.homing.method;
    c.homing_fast_counts_per_s = in_counts(from.homing.fast_deg_per_s);
    c.homing_slow_counts_per_s = in_counts(from.homing.slow_deg_per_s);
    c.homing_acceleration_counts_per_s2 = in_counts(from.homing.acceleration_deg_per_s2);
    c.home_offset_counts = static_cast<std::int32_t>(std::lround(from.homing.switch_deg * from.counts_per_deg));
    double const travel_deg = from.max_deg - from.min_deg + 10.0;
    c.homing_timeout_ms = static_cast<std::uint32_t>(1000.0 * (travel_deg / from.homing.fast_deg_per_s + 20.0));
    c.homing_order = from.homing.order;
    c.following_error_counts = in_counts(from.following_error_deg);
    c.following_error_timeout_ms = from.following_error_timeout_ms;
    c.counts_per_turn = from.counts_per_turn;
    c.quick_stop_deceleration_counts_per_s2 = in_counts(from.quick_stop_deg_per_s2);
    c.brake = from.brake;
    c.gravity = from.gravity;
    return request;
}

std::vector<gn_knot> move_to_start(const Instrument &instrument, const std::array<double, axis_count> &from_counts) {
    gn_knot first{};
    gn_knot last{};
    double duration_s = 0.1;
    for (std::size_t i = 0; i < axis_count; ++i) {
        const Axis_settings &axis = instrument.axes.at(i);
        first.position_counts[i] = from_counts.at(i);
        last.position_counts[i] = centre_deg.at(i) * axis.counts_per_deg;
        double const way_deg = std::abs((last.position_counts[i] - first.position_counts[i]) / axis.counts_per_deg);
        // From rest to rest a quintic's highest speed is 15/8 of its mean, its highest acceleration 5.78 way/time^2.
        duration_s = std::max(duration_s, 1.05 * 1.875 * way_deg / axis.max_velocity_deg_per_s);
        duration_s = std::max(duration_s, 1.05 * std::sqrt(5.78 * way_deg / axis.max_acceleration_deg_per_s2));
    }
    last.time_ns = std::llround(duration_s * 1e9);
    return {first, last};
}

std::vector<gn_knot> sinusoidal_flight(const Instrument &instrument, double duration_s) {
    auto const count = static_cast<std::size_t>(std::ceil(std::max(duration_s, 2.0 * ramp_s) / knot_s));
    double const total_s = static_cast<double>(count) * knot_s;
    std::vector<gn_knot> knots;
    double phase_s = 0.0; // the argument of the sines; it runs at 1 between the ramps
    for (std::size_t k = 0; k <= count; ++k) {
        double const time_s = static_cast<double>(k) * knot_s;
        bool const starting = time_s < 0.5 * total_s;
        double const x = std::min(1.0, (starting ? time_s : total_s - time_s) / ramp_s);
        // Rate 6x^5 - 15x^4 + 10x^3; its integral and its slope.
        double const rate = x * x * x * (10.0 + x * (6.0 * x - 15.0));
        double const ramped_s = ramp_s * x * x * x * x * (2.5 + x * (x - 3.0));
        double const slope_per_s =
            (x < 1.0 ? 30.0 * x * x * (1.0 - x) * (1.0 - x) / ramp_s : 0.0) * (starting ? 1.0 : -1.0);
        double const level_s = std::max(0.0, (starting ? time_s : total_s - time_s) - ramp_s);
        double const end_s = total_s - ramp_s; // the whole phase: each ramp counts half
        phase_s = starting ? ramped_s + level_s : end_s - ramped_s - level_s;
        gn_knot knot{};
        knot.time_ns = std::llround(time_s * 1e9);
        for (std::size_t i = 0; i < axis_count; ++i) {
            const Axis_settings &axis = instrument.axes.at(i);
            double const w = pace_rad_per_s.at(i);
            double const speed = speed_share * axis.max_velocity_deg_per_s * axis.counts_per_deg;
            double const sine = std::sin(w * phase_s);
            double const cosine = std::cos(w * phase_s);
            knot.position_counts[i] = centre_deg.at(i) * axis.counts_per_deg + speed / w * sine;
            knot.velocity_counts_per_s[i] = speed * cosine * rate;
            knot.acceleration_counts_per_s2[i] = speed * (cosine * slope_per_s - w * sine * rate * rate);
        }
        knots.push_back(knot);
    }
    return knots;
}

} // namespace gonio::sim
