/* operation.h: the long requests: Boot, Home, ClearFault, Release; each is refused, or accepted and reported when done.
 */
#ifndef GONIO_OPERATION_H
#define GONIO_OPERATION_H

#include "motion_state.h"

void gn_boot_request(struct gn_motion *motion, uint32_t request_id);
void gn_home_request(struct gn_motion *motion, uint32_t request_id, uint32_t axis_mask);
void gn_clear_fault_request(struct gn_motion *motion, uint32_t request_id);
void gn_release_request(struct gn_motion *motion, uint32_t request_id);
/* Boot goes on with every received frame, the others once per cycle. */
void gn_operation_process(struct gn_motion *motion);
void gn_operation_cycle(struct gn_motion *motion);
/* Stop of a homing under way. */
void gn_home_halt(struct gn_motion *motion, const char *why);

#endif
