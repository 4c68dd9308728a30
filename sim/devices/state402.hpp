// state402.hpp: the state machine of CiA 402-2 with its transitions, quick stop and fault reaction options.
#pragma once

#include <cstdint>

namespace gonio::sim {

enum class Drive_state : std::uint8_t {
    switch_on_disabled = 0,
    ready_to_switch_on = 1,
    switched_on = 2,
    operation_enabled = 3,
    quick_stop_active = 4,
    fault_reaction_active = 5,
    fault = 6,
};

// What brings the axis to rest before the state machine goes on.
enum class Stop_ramp : std::uint8_t { none = 0, slow_down = 1, quick_stop = 2 };

struct Stop_options {
    std::int64_t quick_stop = 2;        // 0x605A
    std::int64_t disable_operation = 1; // 0x605C
    std::int64_t fault_reaction = 2;    // 0x605E
};

// Numbers in comments are the standard's transitions.
class State402 {
public:
    // After power-up or reset: transitions 0 and 1.
    void power_up();
    // A controlword came. Without permission for torque nothing leaves switch on disabled (2 is refused).
    void command(std::uint16_t controlword, bool torque_allowed, const Stop_options &options);
    // From inside: 13 (and 14 if there is nothing to stop). torque: the ramp can be driven.
    void fault(bool torque, const Stop_options &options);
    void quick_stop(const Stop_options &options); // 11
    void disable_voltage();                       // 7, 9, 10, 12
    // The ramp has brought the axis to rest.
    void ramp_finished();

    [[nodiscard]] Drive_state state() const { return state_; }
    [[nodiscard]] Stop_ramp ramp() const { return ramp_; }
    // The axis is under control: operation enabled, quick stop active, fault reaction active.
    [[nodiscard]] bool energised() const;
    // Set-points are followed: operation enabled, and not on the way to switched on.
    [[nodiscard]] bool follows() const { return state_ == Drive_state::operation_enabled && ramp_ == Stop_ramp::none; }
    // Bits 0-3, 5 and 6 of 0x6041.
    [[nodiscard]] std::uint16_t status_bits() const;
    // Whether the last command() was a fault reset that did transition 15; reading it clears it.
    bool take_fault_reset();

private:
    void enter(Drive_state state, Stop_ramp ramp = Stop_ramp::none) {
        state_ = state;
        ramp_ = ramp;
    }
    Drive_state state_ = Drive_state::switch_on_disabled;
    Stop_ramp ramp_ = Stop_ramp::none;
    bool stay_in_quick_stop_ = false;
    bool last_reset_bit_ = false;
    bool fault_reset_ = false;
};

} // namespace gonio::sim
