// drive_objects.cpp: the objects of CiA 402 that the axis works with, looked up once.
#include "drive_objects.hpp"

namespace gonio::sim {

Drive_objects::Drive_objects(Object_dictionary &dictionary)
    : abort_connection(dictionary.find(0x6007)), error_code(dictionary.at(0x603F)), controlword(dictionary.at(0x6040)),
      statusword(dictionary.at(0x6041)), quick_stop_option(dictionary.at(0x605A)),
      disable_option(dictionary.at(0x605C)), fault_option(dictionary.at(0x605E)), mode(dictionary.at(0x6060)),
      mode_display(dictionary.at(0x6061)), demand(dictionary.at(0x6062)), actual(dictionary.at(0x6064)),
      window(dictionary.at(0x6065)), window_timeout_ms(dictionary.at(0x6066)), velocity(dictionary.at(0x606C)),
      target(dictionary.at(0x607A)), home_offset(dictionary.at(0x607C)), min_limit(dictionary.at(0x607D, 1)),
      max_limit(dictionary.at(0x607D, 2)), profile_velocity(dictionary.at(0x6081)),
      profile_acceleration(dictionary.at(0x6083)), profile_deceleration(dictionary.at(0x6084)),
      quick_stop_deceleration(dictionary.at(0x6085)), homing_method(dictionary.at(0x6098)),
      homing_fast(dictionary.at(0x6099, 1)), homing_slow(dictionary.at(0x6099, 2)),
      homing_acceleration(dictionary.at(0x609A)), position_offset(dictionary.at(0x60B0)),
      period_value(dictionary.at(0x60C2, 1)), period_exponent(dictionary.at(0x60C2, 2)),
      max_acceleration(dictionary.at(0x60C5)), following_error(dictionary.at(0x60F4)), inputs(dictionary.at(0x60FD)),
      outputs(dictionary.at(0x60FE, 1)), outputs_mask(dictionary.at(0x60FE, 2)) {}

} // namespace gonio::sim
