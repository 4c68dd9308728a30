/* homing.h: homes one axis in mode 6 and leaves it in cyclic synchronous position, holding. */
#ifndef GONIO_HOMING_H
#define GONIO_HOMING_H

#include "axis.h"
#include "trouble.h"

enum gn_homing_progress { GN_HOMING_RUNNING = 0, GN_HOMING_FINISHED = 1, GN_HOMING_FAILED = 2 };

void gn_homing_begin(struct gn_axis *axis, int64_t now_ns);
/* Once per SYNC cycle. */
enum gn_homing_progress gn_homing_process(struct gn_axis *axis, const struct gn_bus *bus, struct gn_trouble *trouble);
/* Halt a homing under way; the axis stays enabled, its position unknown. */
void gn_homing_halt(struct gn_axis *axis);
bool gn_homing_active(const struct gn_axis *axis);

#endif
