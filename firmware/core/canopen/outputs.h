/* outputs.h: shutter and lamp; every change becomes an event. */
#ifndef GONIO_OUTPUTS_H
#define GONIO_OUTPUTS_H

#include "motion_state.h"

void gn_output_set(struct gn_motion *motion, gonio_Output output, bool on);
void gn_shutter_close(struct gn_motion *motion);
/* From the end of the motion that was ordered until the shutter is told to close, at the latest. */
#define GN_DARK_DEADLINE_MS 250u
/* Close it once the path is over and the axes stand. */
void gn_shutter_close_when_still(struct gn_motion *motion);
/* Once per cycle. */
void gn_shutter_process(struct gn_motion *motion);

#endif
