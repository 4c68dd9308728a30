// axis.cpp: one millisecond of a drive's control of its axis.
#include "axis.hpp"

#include <algorithm>

#include "emcy.hpp"

namespace gonio::sim {
namespace {

constexpr double step_s = 1.0e-9 * static_cast<double>(Servo::step_ns);
constexpr std::uint16_t bit_homing_start = 0x10, bit_change_at_once = 0x20, bit_relative = 0x40, bit_halt = 0x100;
constexpr std::int64_t window_off = 0xFFFFFFFF;
constexpr double settled_counts = 1.0;
// Slow enough to be at rest, as a share of a turn per second.
constexpr double rest_turns_per_s = 1.0e-4;

} // namespace

Axis::Axis(const Axis_config &config, Drive_objects &objects, std::int64_t start_ns)
    : config_(config), objects_(objects), servo_(config.servo, config.initial_position_counts, start_ns),
      brake_(config.brake), homing_(config.index_counts, config.counts_per_turn) {
    power_up();
}

void Axis::power_up() {
    state_.power_up();
    homing_.reset();
    homed_ = homing_bit_ = limit_active_ = at_switch_ = stopping_ = following_ = false;
    beyond_window_ns_ = 0;
    mode_ = mode::none;
    encoder_before_counts_ = zero_counts_ = encoder_counts();
    hold(servo_.end_position_counts() - static_cast<double>(zero_counts_), 0.0);
    latch(servo_.end_ns());
    update_status();
}

void Axis::hold(double position_counts, double velocity_counts_per_s) {
    demand_counts_ = position_counts;
    demand_velocity_counts_per_s_ = velocity_counts_per_s;
    interpolator_.hold(position_counts);
    ramp_.place(position_counts, velocity_counts_per_s);
    profile_.reset(position_counts);
}

double Axis::ramp_limit(const Od_entry &acceleration) const {
    return static_cast<double>(std::min(acceleration.value, objects_.max_acceleration.value));
}

// Software limits (0x607D) hold once the position is known.
double Axis::limited(double target_counts) {
    const auto low = static_cast<double>(objects_.min_limit.value);
    const auto high = static_cast<double>(objects_.max_limit.value);
    limit_active_ = homed_ && low < high && (target_counts < low || target_counts > high);
    return limit_active_ ? std::clamp(target_counts, low, high) : target_counts;
}

bool Axis::command() {
    const auto controlword = static_cast<std::uint16_t>(objects_.controlword.value);
    state_.command(controlword, torque_allowed_, objects_.stop_options());
    const bool was_reset = state_.take_fault_reset();
    if (was_reset) {
        objects_.error_code.value = 0;
    }
    command_homing(controlword);
    if (mode_ == mode::profile_position && following_) {
        auto target = static_cast<double>(objects_.target.value);
        target += (controlword & bit_relative) != 0 ? profile_.last_target_counts() : 0.0;
        profile_.command((controlword & bit_homing_start) != 0, (controlword & bit_change_at_once) != 0,
                         limited(target));
    }
    update_status();
    return was_reset;
}

void Axis::command_homing(std::uint16_t controlword) {
    const bool start = (controlword & bit_homing_start) != 0;
    const bool halt = (controlword & bit_halt) != 0;
    const bool rising = start && !homing_bit_;
    homing_bit_ = start && mode_ == mode::homing && following_;
    if (mode_ != mode::homing) {
        return;
    }
    if (rising && homing_bit_ && !halt) {
        homed_ = false;
        homing_.start({objects_.homing_method.value, static_cast<double>(objects_.homing_fast.value),
                       static_cast<double>(objects_.homing_slow.value), ramp_limit(objects_.homing_acceleration)},
                      homing_input());
    } else if (!homing_bit_ || halt) {
        homing_.interrupt();
    }
}

Homing_input Axis::homing_input() const {
    const double lag = demand_counts_ + static_cast<double>(zero_counts_) - servo_.end_position_counts();
    return {encoder_before_counts_, encoder_counts(), negative_switch(), std::abs(lag) < settled_counts};
}

void Axis::sync(std::int64_t now_ns) {
    if (!following_ || mode_ != mode::cyclic_position || !controlled()) {
        return;
    }
    const auto target = static_cast<double>(objects_.target.value + objects_.position_offset.value);
    double period_ns = static_cast<double>(objects_.period_value.value) * 1.0e9;
    for (std::int64_t k = objects_.period_exponent.value; k < 0; ++k) {
        period_ns /= 10.0;
    }
    interpolator_.take(now_ns, limited(target), std::max<std::int64_t>(1, std::llround(period_ns)));
}

void Axis::change_mode() {
    const std::int64_t wanted = objects_.mode.value;
    if (wanted == mode_ || !mode::supported(wanted) || homing_.running()) {
        return;
    }
    mode_ = wanted;
    limit_active_ = false;
    homing_.reset();
    hold(demand_counts_, demand_velocity_counts_per_s_);
}

std::uint16_t Axis::step() {
    const std::int64_t now_ns = servo_.end_ns();
    const double actual = servo_.end_position_counts() - static_cast<double>(zero_counts_);
    const double speed = std::abs(servo_.end_velocity_counts_per_s());
    const bool slow = speed < 100.0 * rest_turns_per_s * static_cast<double>(config_.counts_per_turn);
    const bool forced = (objects_.outputs.value & objects_.outputs_mask.value & 1) != 0;
    brake_.step(now_ns, state_.energised(), torque_allowed_, forced, slow);
    if (!brake_.torque() || (brake_.closed() && state_.energised())) {
        hold(actual, 0.0);
    }
    change_mode();
    if (state_.follows() != following_) {
        following_ = !following_;
        hold(demand_counts_, following_ ? 0.0 : demand_velocity_counts_per_s_);
    }

    const std::uint16_t code = check_following();
    if (code != 0) {
        fault(code);
    }
    const double start = demand_counts_;
    const double end = next_set_point(start, now_ns);
    encoder_before_counts_ = encoder_counts();
    servo_.step(servo_input(start, end));
    demand_velocity_counts_per_s_ = (end - start) / step_s;
    demand_counts_ = end;
    if (homing_.attained() && !homed_) {
        set_home();
    }
    update_status();
    return code;
}

// Except for homing, no set-point pulls the axis beyond its negative switch, or further if it is there already.
Servo_input Axis::servo_input(double start_counts, double end_counts) {
    const auto zero = static_cast<double>(zero_counts_);
    double start = start_counts + zero;
    double end = end_counts + zero;
    if (!brake_.torque()) {
        given_counts_ = motor_counts_ = servo_.end_position_counts();
    }
    const double floor = std::min(config_.switch_counts, given_counts_);
    at_switch_ = brake_.torque() && mode_ != mode::homing && end < floor;
    if (at_switch_) {
        start = std::max(start, floor);
        end = floor;
    }
    given_counts_ = end;
    if (config_.inverted && brake_.torque()) {
        const double step = end - start;
        start = motor_counts_;
        end = motor_counts_ -= step;
    }
    return {brake_.torque(), brake_.closed(), blocked_, start, end};
}

double Axis::next_set_point(double start_counts, std::int64_t now_ns) {
    if (!brake_.torque()) {
        return start_counts;
    }
    if (state_.ramp() != Stop_ramp::none) {
        return stop_step();
    }
    stopping_ = false;
    if (!following_ || !controlled()) {
        return start_counts;
    }
    const bool halt = (objects_.controlword.value & bit_halt) != 0;
    switch (mode_) {
    case mode::cyclic_position:
        return interpolator_.at(now_ns + Servo::step_ns);
    case mode::homing:
        homing_.step(step_s, homing_input(), ramp_);
        return ramp_.position_counts();
    case mode::profile_position:
        profile_.step(step_s,
                      {static_cast<double>(objects_.profile_velocity.value), ramp_limit(objects_.profile_acceleration),
                       ramp_limit(objects_.profile_deceleration)},
                      halt, ramp_);
        return ramp_.position_counts();
    default:
        ramp_.step_velocity(step_s, 0.0, ramp_limit(objects_.profile_deceleration));
        return ramp_.position_counts();
    }
}

double Axis::stop_step() {
    if (!stopping_) {
        stopping_ = true;
        homing_.fail();
        ramp_.place(demand_counts_, demand_velocity_counts_per_s_);
    }
    const Od_entry &deceleration =
        state_.ramp() == Stop_ramp::quick_stop ? objects_.quick_stop_deceleration : objects_.profile_deceleration;
    ramp_.step_velocity(step_s, 0.0, static_cast<double>(deceleration.value));
    const double rest = rest_turns_per_s * static_cast<double>(config_.counts_per_turn);
    if (ramp_.at_rest() && std::abs(servo_.end_velocity_counts_per_s()) < rest) {
        state_.ramp_finished();
    }
    return ramp_.position_counts();
}

// At home 0x6064 reads the home offset (0x607C): the home position's place in the machine's coordinate.
void Axis::set_home() {
    const std::int64_t zero = homing_.home_counts() - objects_.home_offset.value;
    const auto shift = static_cast<double>(zero - zero_counts_);
    zero_counts_ = zero;
    homed_ = true;
    hold(demand_counts_ - shift, 0.0);
}

std::uint16_t Axis::check_following() {
    const double actual = servo_.end_position_counts() - static_cast<double>(zero_counts_);
    const std::int64_t window = objects_.window.value;
    const bool watched = controlled() && state_.energised() && state_.state() != Drive_state::fault_reaction_active;
    if (!watched || window == window_off || std::abs(demand_counts_ - actual) <= static_cast<double>(window)) {
        beyond_window_ns_ = 0;
        return 0;
    }
    beyond_window_ns_ += Servo::step_ns;
    return beyond_window_ns_ > objects_.window_timeout_ms.value * 1'000'000 ? emcy::following_error : 0;
}

void Axis::fault(std::uint16_t code) {
    objects_.error_code.value = code;
    if (code == emcy::following_error) { // the set-point is far away: stop from where the axis is
        hold(servo_.end_position_counts() - static_cast<double>(zero_counts_), servo_.end_velocity_counts_per_s());
        stopping_ = false;
    }
    homing_.fail();
    state_.fault(torque(), objects_.stop_options());
    update_status();
}

void Axis::quick_stop() {
    state_.quick_stop(objects_.stop_options());
    update_status();
}

void Axis::disable_voltage() {
    state_.disable_voltage();
    update_status();
}

bool Axis::set_torque_allowed(bool allowed) {
    torque_allowed_ = allowed;
    if (allowed) {
        update_status();
        return false;
    }
    const bool lost = state_.energised();
    if (lost) {
        fault(emcy::sto);
    } else {
        disable_voltage();
    }
    return lost;
}

void Axis::latch(std::int64_t time_ns) {
    objects_.actual.value = std::llround(servo_.position_counts(time_ns)) - zero_counts_;
    objects_.velocity.value = std::llround(servo_.velocity_counts_per_s(time_ns));
    const double since = static_cast<double>(servo_.end_ns() - time_ns) / static_cast<double>(Servo::step_ns);
    const double demand = demand_counts_ - std::clamp(since, 0.0, 1.0) * step_s * demand_velocity_counts_per_s_;
    objects_.demand.value = std::llround(demand);
    objects_.following_error.value = objects_.demand.value - objects_.actual.value;
}

void Axis::update_status() {
    constexpr unsigned voltage = 0x10, remote = 0x200, reached = 0x400, limit = 0x800, bit12 = 0x1000, bit13 = 0x2000;
    constexpr unsigned switch_input = 1, interlock_input = 8;
    unsigned word = state_.status_bits() | voltage | remote | (limit_active_ || at_switch_ ? limit : 0);
    switch (mode_) {
    case mode::cyclic_position:
        word |= following_ && controlled() && state_.follows() ? bit12 : 0;
        word |= beyond_window_ns_ != 0 ? bit13 : 0;
        break;
    case mode::homing:
        word |= homing_.running() ? 0 : reached;
        word |= homed_ && homing_.attained() ? bit12 : 0;
        word |= homing_.failed() ? bit13 : 0;
        break;
    case mode::profile_position:
        word |= profile_.reached() ? reached : 0;
        word |= profile_.acknowledged() ? bit12 : 0;
        word |= beyond_window_ns_ != 0 ? bit13 : 0;
        break;
    default:
        break;
    }
    objects_.statusword.value = word;
    objects_.mode_display.value = mode_;
    objects_.inputs.value = (negative_switch() ? switch_input : 0) | (torque_allowed_ ? 0 : interlock_input);
}

} // namespace gonio::sim
