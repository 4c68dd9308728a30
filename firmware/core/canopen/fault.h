/* fault.h: from trouble to the safe state and one sentence. */
#ifndef GONIO_FAULT_H
#define GONIO_FAULT_H

#include "motion_state.h"
#include "trouble.h"

/* `axis`: the one in trouble, or GN_NO_AXIS. Axes of `failed_mask` are quick-stopped, the others hold on their path.
 * The first fault is the one reported; what follows until ClearFault is logged. */
void gn_fault_raise(struct gn_motion *motion, uint32_t axis, uint32_t failed_mask, const struct gn_trouble *trouble);

#endif
