/* cycle.h: what happens once per SYNC period, and on each received frame. */
#ifndef GONIO_CYCLE_H
#define GONIO_CYCLE_H

#include "motion_state.h"

void gn_frames_process(struct gn_motion *motion);
/* When it is due: pose, path step, SYNC; and the RPDOs, after the SYNC's echo. */
void gn_cycle_process(struct gn_motion *motion);
/* When to be called again at the latest. */
int64_t gn_cycle_next_ns(const struct gn_motion *motion);

#endif
