/* motion.h: the real-time thread's entry point: CAN, edges, outputs, the drives and the path. */
#ifndef GONIO_MOTION_H
#define GONIO_MOTION_H

#include "port.h"
#include "shared.h"

struct gn_motion; /* defined in motion_state.h; one static instance, no allocation */

struct gn_motion *gn_motion_init(const struct gn_port *port, struct gn_shared *shared);
/* Do all that is due; returns when to be called again at the latest (controller clock, ns). */
int64_t gn_motion_process(struct gn_motion *motion, int64_t now_ns);

#endif
