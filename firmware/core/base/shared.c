/* shared.c: sets up the rings between the two threads. */
#include "shared.h"

#include <string.h>

void gn_shared_init(struct gn_shared *shared) {
    memset(shared, 0, sizeof *shared);
    shared->kernel = "";
    gn_ring_init(&shared->commands, shared->command_slots, sizeof(struct gn_command), GN_COMMAND_CAPACITY);
    gn_ring_init(&shared->knots, shared->knot_slots, sizeof(struct gn_knot_item), GN_KNOT_CAPACITY);
    gn_ring_init(&shared->notices, shared->notice_slots, sizeof(struct gn_notice), GN_NOTICE_CAPACITY);
    gn_ring_init(&shared->poses, shared->pose_slots, sizeof(struct gn_pose), GN_POSE_CAPACITY);
    gn_ring_init(&shared->strobes, shared->strobe_slots, sizeof(struct gn_edge), GN_STROBE_CAPACITY);
}
