// state402.cpp: the state machine of CiA 402-2.
#include "state402.hpp"

namespace gonio::sim {

void State402::power_up() {
    enter(Drive_state::switch_on_disabled);
    last_reset_bit_ = false;
    fault_reset_ = false;
}

bool State402::energised() const {
    return state_ == Drive_state::operation_enabled || state_ == Drive_state::quick_stop_active ||
           state_ == Drive_state::fault_reaction_active;
}

void State402::command(std::uint16_t controlword, bool torque_allowed, const Stop_options &options) {
    const bool reset_bit = (controlword & 0x80U) != 0;
    const bool reset = reset_bit && !last_reset_bit_;
    last_reset_bit_ = reset_bit;
    if (state_ == Drive_state::fault) {
        if (reset && torque_allowed) { // 15
            enter(Drive_state::switch_on_disabled);
            fault_reset_ = true;
        }
        return;
    }
    if (state_ == Drive_state::fault_reaction_active || reset_bit) {
        return; // with bit 7 set the other bits command nothing
    }
    if ((controlword & 0x02U) == 0) { // disable voltage
        disable_voltage();
        return;
    }
    if ((controlword & 0x04U) == 0) { // quick stop
        if (state_ == Drive_state::operation_enabled) {
            quick_stop(options);
        } else if (state_ != Drive_state::quick_stop_active) {
            enter(Drive_state::switch_on_disabled); // 7, 10
        }
        return;
    }
    const bool switch_on = (controlword & 0x01U) != 0;
    const bool enable = switch_on && (controlword & 0x08U) != 0;
    switch (state_) {
    case Drive_state::switch_on_disabled:
        if (!switch_on && torque_allowed) { // 2
            enter(Drive_state::ready_to_switch_on);
        }
        break;
    case Drive_state::ready_to_switch_on:
        if (switch_on) { // 3, and 4 in one go
            enter(enable ? Drive_state::operation_enabled : Drive_state::switched_on);
        }
        break;
    case Drive_state::switched_on:
        if (!switch_on) { // 6
            enter(Drive_state::ready_to_switch_on);
        } else if (enable) { // 4
            enter(Drive_state::operation_enabled);
        }
        break;
    case Drive_state::operation_enabled:
        if (!switch_on) { // 8
            enter(Drive_state::ready_to_switch_on);
        } else if (enable) {
            ramp_ = Stop_ramp::none;
        } else if (options.disable_operation == 1) { // 5, once the axis is at rest
            ramp_ = Stop_ramp::slow_down;
        } else {
            enter(Drive_state::switched_on); // 5
        }
        break;
    case Drive_state::quick_stop_active:
        if (enable && stay_in_quick_stop_) { // 16
            enter(Drive_state::operation_enabled);
        }
        break;
    case Drive_state::fault_reaction_active:
    case Drive_state::fault:
        break;
    }
}

void State402::quick_stop(const Stop_options &options) {
    if (state_ != Drive_state::operation_enabled) {
        return;
    }
    if (options.quick_stop == 0) { // 11 and 12
        enter(Drive_state::switch_on_disabled);
        return;
    }
    stay_in_quick_stop_ = options.quick_stop >= 5;
    const bool slowly = options.quick_stop == 1 || options.quick_stop == 5;
    enter(Drive_state::quick_stop_active, slowly ? Stop_ramp::slow_down : Stop_ramp::quick_stop);
}

void State402::disable_voltage() {
    if (state_ != Drive_state::fault && state_ != Drive_state::fault_reaction_active) {
        enter(Drive_state::switch_on_disabled);
    }
}

void State402::fault(bool torque, const Stop_options &options) {
    if (state_ == Drive_state::fault) {
        return;
    }
    if (!torque || !energised() || options.fault_reaction == 0) { // 13, 14
        enter(Drive_state::fault);
        return;
    }
    if (state_ != Drive_state::fault_reaction_active) { // 13
        enter(Drive_state::fault_reaction_active,
              options.fault_reaction == 1 ? Stop_ramp::slow_down : Stop_ramp::quick_stop);
    }
}

void State402::ramp_finished() {
    switch (state_) {
    case Drive_state::operation_enabled:
        if (ramp_ != Stop_ramp::none) { // 5
            enter(Drive_state::switched_on);
        }
        break;
    case Drive_state::quick_stop_active:
        if (!stay_in_quick_stop_) { // 12
            enter(Drive_state::switch_on_disabled);
        }
        break;
    case Drive_state::fault_reaction_active: // 14
        enter(Drive_state::fault);
        break;
    default:
        break;
    }
}

std::uint16_t State402::status_bits() const {
    switch (state_) {
    case Drive_state::switch_on_disabled:
        return 0x40;
    case Drive_state::ready_to_switch_on:
        return 0x21;
    case Drive_state::switched_on:
        return 0x23;
    case Drive_state::operation_enabled:
        return 0x27;
    case Drive_state::quick_stop_active:
        return 0x07;
    case Drive_state::fault_reaction_active:
        return 0x0F;
    case Drive_state::fault:
        return 0x08;
    }
    return 0;
}

bool State402::take_fault_reset() {
    const bool was = fault_reset_;
    fault_reset_ = false;
    return was;
}

} // namespace gonio::sim
