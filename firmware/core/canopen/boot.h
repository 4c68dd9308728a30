/* boot.h: brings one drive from reset to operational by the table of steps, with the fallbacks of lesser drives. */
#ifndef GONIO_BOOT_H
#define GONIO_BOOT_H

#include "axis.h"
#include "trouble.h"

enum gn_boot_progress {
    GN_BOOT_RUNNING = 0,
    GN_BOOT_CONFIGURED = 1, /* waits for start_allowed */
    GN_BOOT_DONE = 2,
    GN_BOOT_FAILED = 3, /* the trouble says why */
};

void gn_boot_begin(struct gn_axis *axis);
/* Everything that can be done now. Heartbeats, boot-ups and SDO answers reach the axis's machines before. */
enum gn_boot_progress gn_boot_process(struct gn_axis *axis, const struct gn_bus *bus, struct gn_trouble *trouble);

#endif
