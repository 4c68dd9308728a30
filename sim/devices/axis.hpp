// axis.hpp: the drive's control of its axis, once per ms: state machine, mode of operation, set-point, brake, limits.
#pragma once

#include <cmath>
#include <cstdint>

#include "brake.hpp"
#include "drive_objects.hpp"
#include "homing.hpp"
#include "servo.hpp"
#include "set_points.hpp"
#include "state402.hpp"

namespace gonio::sim {

struct Axis_config {
    Servo_config servo;
    Brake_config brake;
    double initial_position_counts = 0.0;
    std::int64_t index_counts = 0; // of one index pulse; the others are whole turns away
    std::int64_t counts_per_turn = 400000;
    double switch_counts = 0.0; // the negative limit switch is closed at and below
    bool inverted = false;      // the motor turns the other way
};

namespace mode {
constexpr std::int64_t none = 0, profile_position = 1, homing = 6, cyclic_position = 8;
constexpr bool supported(std::int64_t mode) {
    return mode == none || mode == profile_position || mode == homing || mode == cyclic_position;
}
} // namespace mode

// Two coordinates: the encoder's counts (the true position, rounded; the twin's axis coordinate) and the drive's own,
// which 0x6064, 0x607A and the limits are in: encoder counts minus zero_counts_.
class Axis {
public:
    Axis(const Axis_config &config, Drive_objects &objects, std::int64_t start_ns);

    // Power-up or reset: 0x6064 reads 0, home is unknown, no torque.
    void power_up();
    // The controlword or the mode of operation was written. True: a fault was reset.
    bool command();
    // Take over the cyclic target.
    void sync(std::int64_t now_ns);
    // One step of 1 ms, beginning now (= next_step_ns()). An emergency code if a fault was found, else 0.
    std::uint16_t step();
    [[nodiscard]] std::int64_t next_step_ns() const { return servo_.end_ns(); }

    // An error from elsewhere in the drive: 0x603F and the fault reaction.
    void fault(std::uint16_t code);
    void quick_stop();
    void disable_voltage();
    // True: torque was lost under control, which is a fault.
    bool set_torque_allowed(bool allowed);
    void block(bool blocked) { blocked_ = blocked; }
    // Bring position, velocity and following error in the dictionary to those of this time.
    void latch(std::int64_t time_ns);

    [[nodiscard]] const Servo &servo() const { return servo_; }
    [[nodiscard]] const State402 &state() const { return state_; }
    [[nodiscard]] bool torque() const { return brake_.torque() && torque_allowed_; }
    [[nodiscard]] bool brake_closed() const { return brake_.closed(); }
    [[nodiscard]] bool homed() const { return homed_; }

private:
    [[nodiscard]] std::int64_t encoder_counts() const { return std::llround(servo_.end_position_counts()); }
    [[nodiscard]] bool negative_switch() const { return servo_.end_position_counts() <= config_.switch_counts; }
    // The axis moves by set-points: torque, and the brake is open.
    [[nodiscard]] bool controlled() const { return brake_.torque() && !brake_.closed(); }
    [[nodiscard]] double ramp_limit(const Od_entry &acceleration) const;
    [[nodiscard]] Homing_input homing_input() const;
    double limited(double target_counts);
    void change_mode();
    void hold(double position_counts, double velocity_counts_per_s);
    void command_homing(std::uint16_t controlword);
    [[nodiscard]] Servo_input servo_input(double start_counts, double end_counts);
    double next_set_point(double start_counts, std::int64_t now_ns);
    double stop_step();
    void set_home();
    std::uint16_t check_following();
    void update_status();

    Axis_config config_;
    Drive_objects &objects_;
    Servo servo_;
    Brake brake_;
    State402 state_;
    Ramp ramp_;
    Interpolator interpolator_;
    Profile_position profile_;
    Homing homing_;
    std::int64_t zero_counts_ = 0;
    std::int64_t encoder_before_counts_ = 0;
    std::int64_t mode_ = mode::none;
    double demand_counts_ = 0.0; // at next_step_ns(), in the drive's coordinate
    double demand_velocity_counts_per_s_ = 0.0;
    double given_counts_ = 0.0; // the servo's last set-point, in the encoder's coordinate
    double motor_counts_ = 0.0; // the same of a motor that turns the other way
    std::int64_t beyond_window_ns_ = 0;
    bool stopping_ = false;
    bool following_ = false;
    bool homing_bit_ = false;
    bool limit_active_ = false; // of the software limits
    bool at_switch_ = false;    // the negative switch holds the axis back
    bool homed_ = false;
    bool torque_allowed_ = true;
    bool blocked_ = false;
};

} // namespace gonio::sim
