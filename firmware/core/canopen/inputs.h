/* inputs.h: strobe, door, emergency stop, STO and limit lines. */
#ifndef GONIO_INPUTS_H
#define GONIO_INPUTS_H

#include "motion_state.h"

void gn_inputs_init(struct gn_motion *motion);
void gn_inputs_process(struct gn_motion *motion);
/* NULL: all closed or released; else a sentence that says which is not. */
const char *gn_inputs_obstacle(const struct gn_motion *motion);
/* The same for a path: unlike homing it may not begin on a limit switch. */
const char *gn_inputs_path_obstacle(const struct gn_motion *motion);

#endif
