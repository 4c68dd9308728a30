/* input_lines.c: the interlock lines as a table. */
#include "input_lines.h"

#include <stddef.h>

#define MAKE_SAFE "make it safe, then clear the fault and home"

static const struct gn_input_line lines[GN_LINE_COUNT] = {
    [GN_LINE_DOOR] = {gonio_FaultCode_FAULT_DOOR, false, false, "the door was opened while drives were enabled",
                      MAKE_SAFE, "the door is open: close it"},
    [GN_LINE_EMERGENCY_STOP] = {gonio_FaultCode_FAULT_EMERGENCY_STOP, true, false, "the emergency stop was pressed",
                                MAKE_SAFE, "the emergency stop is pressed: release it"},
    [GN_LINE_STO] = {gonio_FaultCode_FAULT_STO, true, false, "STO took the drives' torque away", MAKE_SAFE,
                     "STO is active: close the safety circuit"},
    [GN_LINE_LIMIT] = {gonio_FaultCode_FAULT_LIMIT, false, true, "a limit switch was reached",
                       "check min_deg, max_deg and the sign of counts_per_deg, then clear the fault and home",
                       "a limit switch is reached: home to leave it"},
};

const struct gn_input_line *gn_input_line(uint32_t line) {
    return &lines[line];
}

static const char *obstacle_among(const struct gn_motion *motion, bool with_limits) {
    for (uint32_t line = GN_LINE_DOOR; line < GN_LINE_COUNT; line++) {
        if ((motion->inputs & gn_input_bit(line)) == 0u && (with_limits || !lines[line].while_riding)) {
            return lines[line].obstacle;
        }
    }
    return NULL;
}

const char *gn_inputs_obstacle(const struct gn_motion *motion) {
    return obstacle_among(motion, false);
}

const char *gn_inputs_path_obstacle(const struct gn_motion *motion) {
    return obstacle_among(motion, true);
}
