// servo.hpp: the axis and its position loop: a critically damped follower with bounded acceleration, in steps of 1 ms.
#pragma once

#include <array>
#include <cstdint>

namespace gonio::sim {

struct Servo_config {
    double bandwidth_hz = 50.0;
    double max_acceleration_counts_per_s2 = 1.0e6;
    double friction_counts_per_s2 = 3.0e5;
    double gravity_counts_per_s2 = 0.0;
};

// What acts on the axis during a step.
struct Servo_input {
    bool torque = false;
    bool held = false;          // by the brake
    bool blocked = false;       // by an obstacle: stops within the step
    double demand_counts = 0.0; // at the step's start
    double demand_end_counts = 0.0;
};

// The axis' motion between the ends of its steps is the cubic through position and velocity there: smooth, and known at
// any time. A step is computed when it begins, so the present lies within the last one.
class Servo {
public:
    static constexpr std::int64_t step_ns = 1'000'000;

    Servo(const Servo_config &config, double position_counts, std::int64_t start_ns);

    // Compute the step that begins at end_ns().
    void step(const Servo_input &input);

    [[nodiscard]] std::int64_t end_ns() const { return start_ns_ + steps_ * step_ns; }
    // From history_steps steps before end_ns() to end_ns(); times outside give the nearest.
    [[nodiscard]] double position_counts(std::int64_t time_ns) const;
    [[nodiscard]] double velocity_counts_per_s(std::int64_t time_ns) const;
    [[nodiscard]] double end_position_counts() const { return node(steps_).position_counts; }
    [[nodiscard]] double end_velocity_counts_per_s() const { return node(steps_).velocity_counts_per_s; }

    static constexpr std::int64_t history_steps = 63;

private:
    struct Node {
        double position_counts;
        double velocity_counts_per_s;
    };
    struct Place { // a time as a step's first node and the fraction of the step
        std::int64_t first;
        double fraction;
    };
    [[nodiscard]] const Node &node(std::int64_t step) const { return nodes_[static_cast<std::size_t>(step) % 64]; }
    [[nodiscard]] Place place(std::int64_t time_ns) const;
    [[nodiscard]] double near_counts() const;
    [[nodiscard]] Node follow(const Node &from, const Servo_input &input) const;
    [[nodiscard]] Node coast(const Node &from, double braking_counts_per_s2) const;

    Servo_config config_;
    double omega_rad_per_s_;
    double decay_; // exp(-omega * step)
    std::int64_t start_ns_;
    std::int64_t steps_ = history_steps; // index of the newest node; the ring starts filled with the start position
    std::array<Node, 64> nodes_;
};

} // namespace gonio::sim
