/* ride.h: the cycle's side of a path: its start, its end, and what a hold means for the instrument. */
#ifndef GONIO_RIDE_H
#define GONIO_RIDE_H

#include "motion_state.h"

void gn_ride_begin(struct gn_motion *motion, const gonio_Request *request);
/* Take the knots that had arrived when `count` was read. */
void gn_ride_take_knots(struct gn_motion *motion, uint32_t count);
/* Once per cycle: the targets of the axes that follow the path. */
void gn_ride_step(struct gn_motion *motion);
/* Controlled stop; the first reason stays, but a fault replaces it. */
void gn_ride_halt(struct gn_motion *motion, gonio_PathEnd end);

/* From the order to stop until the axes stand and the shutter is shut, at the latest: the hold at its guaranteed rate,
 * the drives' lag, the shutter, two cycles. */
uint32_t gn_ride_stop_ms(const gonio_Configure *cycle);
/* How long the host may be silent before the stop begins, so that it is over at the expiry. */
int64_t gn_ride_patience_ns(const gonio_Configure *cycle);

#endif
