/* outputs.c: shutter and lamp, and the shutter's closing after a controlled stop. */
#include "outputs.h"

#include "notice.h"

/* The drives lag their targets by some milliseconds; noise of an encoder must not keep the shutter open. */
#define STILL_COUNTS 1
#define STILL_CYCLES 5u

void gn_output_set(struct gn_motion *motion, gonio_Output output, bool on) {
    gonio_Event event = {.which_body = gonio_Event_output_tag};
    event.body.output = (gonio_SetOutput){.output = output, .on = on};
    motion->port->out.set(motion->port->out.context, output, on);
    if (output == gonio_Output_OUTPUT_SHUTTER) {
        motion->shutter_open = on;
        motion->dark_when_still = false;
    } else {
        motion->lamp_on = on;
    }
    gn_event(motion, &event);
}

void gn_shutter_close(struct gn_motion *motion) {
    if (motion->shutter_open) {
        gn_output_set(motion, gonio_Output_OUTPUT_SHUTTER, false);
    }
}

void gn_shutter_close_when_still(struct gn_motion *motion) {
    if (motion->shutter_open && !motion->dark_when_still) {
        motion->dark_when_still = true;
        motion->still_cycles = 0;
        motion->dark_deadline_ns = motion->now_ns + (int64_t)GN_DARK_DEADLINE_MS * 1000000;
    }
}

void gn_shutter_process(struct gn_motion *motion) {
    bool still = true;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        int64_t const moved = (int64_t)motion->axes[i].measured_counts - motion->standing_counts[i];
        still = still && moved <= STILL_COUNTS && moved >= -STILL_COUNTS;
        motion->standing_counts[i] = motion->axes[i].measured_counts;
    }
    motion->still_cycles = still ? motion->still_cycles + 1u : 0u;
    if (motion->path.state != GN_PATH_IDLE) { /* a hold may be slow, and what it passes is still measured */
        motion->dark_deadline_ns = motion->now_ns + (int64_t)GN_DARK_DEADLINE_MS * 1000000;
    } else if (motion->dark_when_still &&
               (motion->still_cycles >= STILL_CYCLES || motion->now_ns >= motion->dark_deadline_ns)) {
        gn_shutter_close(motion);
    }
}
