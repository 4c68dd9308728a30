// drive_objects.hpp: the objects of CiA 402 that the axis works with, looked up once.
#pragma once

#include "object_dictionary.hpp"
#include "state402.hpp"

namespace gonio::sim {

struct Drive_objects {
    // Throws std::runtime_error if the EDS lacks one that every personality has.
    explicit Drive_objects(Object_dictionary &dictionary);

    Od_entry *abort_connection;                                  // 0x6007; nullptr in personality "basic"
    Od_entry &error_code;                                        // 0x603F
    Od_entry &controlword;                                       // 0x6040
    Od_entry &statusword;                                        // 0x6041
    Od_entry &quick_stop_option, &disable_option, &fault_option; // 0x605A, 0x605C, 0x605E
    Od_entry &mode, &mode_display;                               // 0x6060, 0x6061
    Od_entry &demand, &actual;                                   // 0x6062, 0x6064
    Od_entry &window, &window_timeout_ms;                        // 0x6065, 0x6066
    Od_entry &velocity;                                          // 0x606C
    Od_entry &target;                                            // 0x607A
    Od_entry &home_offset;                                       // 0x607C
    Od_entry &min_limit, &max_limit;                             // 0x607D
    Od_entry &profile_velocity, &profile_acceleration;           // 0x6081, 0x6083
    Od_entry &profile_deceleration, &quick_stop_deceleration;    // 0x6084, 0x6085
    Od_entry &homing_method, &homing_fast, &homing_slow;         // 0x6098, 0x6099
    Od_entry &homing_acceleration;                               // 0x609A
    Od_entry &position_offset;                                   // 0x60B0
    Od_entry &period_value, &period_exponent;                    // 0x60C2
    Od_entry &max_acceleration;                                  // 0x60C5
    Od_entry &following_error;                                   // 0x60F4
    Od_entry &inputs;                                            // 0x60FD
    Od_entry &outputs, &outputs_mask;                            // 0x60FE

    [[nodiscard]] Stop_options stop_options() const {
        return {quick_stop_option.value, disable_option.value, fault_option.value};
    }
};

} // namespace gonio::sim
