/* monitor.h: watches the drives: heartbeats, boot-ups, emergencies, statuswords, the bus itself. */
#ifndef GONIO_MONITOR_H
#define GONIO_MONITOR_H

#include "motion_state.h"

/* Once per cycle. */
void gn_monitor_nodes(struct gn_motion *motion);
void gn_monitor_bus(struct gn_motion *motion);
/* NULL: the bus can be used; else a sentence that says why not. */
const char *gn_monitor_bus_obstacle(const struct gn_motion *motion);
/* When a statusword came. */
void gn_monitor_drive(struct gn_motion *motion, uint32_t axis);
/* A frame with COB 0x080 + node. */
void gn_monitor_emergency(struct gn_motion *motion, uint32_t axis, const struct gn_can_frame *frame);

#endif
