// servo.cpp: motion of an axis under its position loop, its brake, friction and gravity.
#include "servo.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gonio::sim {
namespace {

constexpr double step_s = 1.0e-9 * static_cast<double>(Servo::step_ns);

} // namespace

Servo::Servo(const Servo_config &config, double position_counts, std::int64_t start_ns)
    : config_(config), omega_rad_per_s_(2.0 * std::numbers::pi * config.bandwidth_hz),
      decay_(std::exp(-omega_rad_per_s_ * step_s)), start_ns_(start_ns - history_steps * step_ns) {
    nodes_.fill(Node{position_counts, 0.0});
}

void Servo::step(const Servo_input &input) {
    const Node from = node(steps_);
    Node to{};
    if (input.blocked) {
        to = Node{from.position_counts + 0.5 * from.velocity_counts_per_s * step_s, 0.0};
    } else if (input.held) {
        to = coast(from, config_.friction_counts_per_s2 + config_.max_acceleration_counts_per_s2);
    } else if (input.torque) {
        to = follow(from, input);
    } else {
        to = coast(from, config_.friction_counts_per_s2);
    }
    ++steps_;
    nodes_[static_cast<std::size_t>(steps_) % 64] = to;
}

// x'' = w^2 (r - x) - 2 w x' with r linear over the step: x = r - 2 r'/w + (A + B t) exp(-w t), exact for any step.
Servo::Node Servo::follow(const Node &from, const Servo_input &input) const {
    const double w = omega_rad_per_s_;
    const double slope = (input.demand_end_counts - input.demand_counts) / step_s;
    const double a = from.position_counts - input.demand_counts + 2.0 * slope / w;
    const double b = from.velocity_counts_per_s - slope + w * a;
    const double end = a + b * step_s;
    const Node to{input.demand_end_counts - 2.0 * slope / w + end * decay_, slope + (b - w * end) * decay_};
    const double first = w * (w * a - 2.0 * b);
    const double last = w * (w * end - 2.0 * b) * decay_;
    const double most = config_.max_acceleration_counts_per_s2;
    const double near = near_counts();
    if (std::abs(first) <= most && std::abs(last) <= most && std::abs(a) <= near && std::abs(end * decay_) <= near) {
        return to;
    }
    // The same law as a cascade, 2 w (v' - x') with v' = r' - w a / 2, but far away v' is no more than can be braked.
    const double approach = std::abs(a) <= near ? 0.5 * w * std::abs(a) : std::sqrt(most * (std::abs(a) - 0.5 * near));
    const double wanted = slope - std::copysign(approach, a);
    const double limited = std::clamp(2.0 * w * (wanted - from.velocity_counts_per_s), -most, most);
    return Node{from.position_counts + (from.velocity_counts_per_s + 0.5 * limited * step_s) * step_s,
                from.velocity_counts_per_s + limited * step_s};
}

// Where the linear law w a / 2 meets the root of braking with half the limit, with the same slope.
double Servo::near_counts() const {
    return 2.0 * config_.max_acceleration_counts_per_s2 / (omega_rad_per_s_ * omega_rad_per_s_);
}

// Without torque: friction against the motion, gravity if it overcomes friction.
Servo::Node Servo::coast(const Node &from, double braking_counts_per_s2) const {
    const double v = from.velocity_counts_per_s;
    const double gravity = config_.gravity_counts_per_s2;
    const bool sticks = std::abs(gravity) <= braking_counts_per_s2;
    if (v == 0.0 && sticks) {
        return from;
    }
    const double direction = v != 0.0 ? v : gravity;
    const double acceleration = gravity - std::copysign(braking_counts_per_s2, direction);
    const double next = v + acceleration * step_s;
    if (sticks && next * v <= 0.0) { // comes to rest within the step
        return Node{from.position_counts - 0.5 * v * v / acceleration, 0.0};
    }
    return Node{from.position_counts + 0.5 * (v + next) * step_s, next};
}

Servo::Place Servo::place(std::int64_t time_ns) const {
    const std::int64_t oldest = steps_ - history_steps;
    const std::int64_t since = std::clamp(time_ns - start_ns_, oldest * step_ns, steps_ * step_ns);
    const std::int64_t first = std::min(since / step_ns, steps_ - 1);
    return {first, static_cast<double>(since - first * step_ns) / static_cast<double>(step_ns)};
}

double Servo::position_counts(std::int64_t time_ns) const {
    const auto [first, u] = place(time_ns);
    const Node &from = node(first);
    const Node &to = node(first + 1);
    const double change = to.position_counts - from.position_counts;
    const double v0 = from.velocity_counts_per_s * step_s;
    const double v1 = to.velocity_counts_per_s * step_s;
    return from.position_counts + u * (v0 + u * (3.0 * change - 2.0 * v0 - v1 + u * (v0 + v1 - 2.0 * change)));
}

double Servo::velocity_counts_per_s(std::int64_t time_ns) const {
    const auto [first, u] = place(time_ns);
    const Node &from = node(first);
    const Node &to = node(first + 1);
    const double change = to.position_counts - from.position_counts;
    const double v0 = from.velocity_counts_per_s * step_s;
    const double v1 = to.velocity_counts_per_s * step_s;
    return (v0 + u * (2.0 * (3.0 * change - 2.0 * v0 - v1) + 3.0 * u * (v0 + v1 - 2.0 * change))) / step_s;
}

} // namespace gonio::sim
