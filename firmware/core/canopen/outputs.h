/* outputs.h: shutter and lamp; every change becomes an event. */
#ifndef GONIO_OUTPUTS_H
#define GONIO_OUTPUTS_H

#include "motion_state.h"

void gn_output_set(struct gn_motion *motion, gonio_Output output, bool on);
void gn_shutter_close(struct gn_motion *motion);
/* Close it once the axes stand, a quarter of a second from now at the latest. */
void gn_shutter_close_when_still(struct gn_motion *motion);
/* Once per cycle. */
void gn_shutter_process(struct gn_motion *motion);

#endif
