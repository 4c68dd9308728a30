/* inputs.h: strobe, door, emergency stop, STO and limit lines. */
#ifndef GONIO_INPUTS_H
#define GONIO_INPUTS_H

#include "motion_state.h"

void gn_inputs_init(struct gn_motion *motion);
void gn_inputs_process(struct gn_motion *motion);

#endif
