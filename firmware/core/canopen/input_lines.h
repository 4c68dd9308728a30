/* input_lines.h: what each interlock line means: its fault, and what stands in the way while it is low. */
#ifndef GONIO_INPUT_LINES_H
#define GONIO_INPUT_LINES_H

#include "edge.h"
#include "motion_state.h"

struct gn_input_line {
    gonio_FaultCode code;
    bool torque_off;   /* the line takes the drives' torque away */
    bool while_riding; /* a fault only while a path moves the axes: homing is meant to reach the switches */
    const char *cause;
    const char *remedy;
    const char *obstacle;
};

/* Of GN_LINE_DOOR and those after it. */
const struct gn_input_line *gn_input_line(uint32_t line);
/* In gn_motion.inputs. */
static inline uint32_t gn_input_bit(uint32_t line) {
    return 1u << (line - 1u);
}
/* NULL: all closed or released; else a sentence that says which is not. */
const char *gn_inputs_obstacle(const struct gn_motion *motion);
/* The same for a path: unlike homing it may not begin on a limit switch. */
const char *gn_inputs_path_obstacle(const struct gn_motion *motion);

#endif
