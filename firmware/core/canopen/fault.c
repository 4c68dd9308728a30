/* fault.c: the safe state (hold or quick stop, dark, position unknown) and the fault's sentence. */
#include "fault.h"

#include <stdio.h>

#include "homing.h"
#include "log.h"
#include "notice.h"
#include "outputs.h"
#include "ride.h"

/* Cause, place, commanded and measured position, remedy. */
static void compose(const struct gn_motion *motion, uint32_t axis_number, const struct gn_trouble *trouble, char *text,
                    uint32_t size) {
    if (axis_number == GN_NO_AXIS) {
        (void)snprintf(text, size, "%s; position unknown; %s", trouble->cause, trouble->remedy);
        return;
    }
    const struct gn_axis *axis = &motion->axes[axis_number];
    if (!axis->measured) {
        (void)snprintf(text, size, "%.23s (node %u): %s; %s", axis->config.name, (unsigned)axis->config.node,
                       trouble->cause, trouble->remedy);
        return;
    }
    double const scale = 1.0 / axis->config.counts_per_deg;
    (void)snprintf(text, size, "%.23s (node %u): %s; commanded %ld counts (%.3f deg), measured %ld (%.3f deg); %s",
                   axis->config.name, (unsigned)axis->config.node, trouble->cause, (long)axis->target_counts,
                   axis->target_counts * scale, (long)axis->measured_counts, axis->measured_counts * scale,
                   trouble->remedy);
}

static void make_safe(struct gn_motion *motion, uint32_t failed_mask) {
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        struct gn_axis *axis = &motion->axes[i];
        axis->homed = false;
        if (gn_homing_active(axis)) {
            gn_homing_halt(axis);
        }
        if (failed_mask & 1u << i) {
            axis->failed = true;
            axis->enabled = false;
            axis->drive.goal = GN_GOAL_QUICK_STOP;
        } else if (!axis->enabled && axis->drive.goal == GN_GOAL_ENABLED) {
            axis->drive.goal = GN_GOAL_RELEASED; /* it was on its way up */
        }
    }
    gn_shutter_close(motion);
}

void gn_fault_raise(struct gn_motion *motion, uint32_t axis, uint32_t failed_mask, const struct gn_trouble *trouble) {
    bool const first = motion->state != gonio_InstrumentState_STATE_FAULT;
    gonio_Event event = {.which_body = gonio_Event_fault_tag};
    gonio_Fault *fault = &event.body.fault;
    *fault = (gonio_Fault){.code = trouble->code, .axis = axis, .index = trouble->index, .subindex = trouble->subindex};
    compose(motion, axis, trouble, fault->sentence, sizeof fault->sentence);
    if (axis != GN_NO_AXIS) {
        fault->node = motion->axes[axis].config.node;
        fault->commanded_counts = motion->axes[axis].target_counts;
        fault->measured_counts = motion->axes[axis].measured_counts;
    }
    motion->state = gonio_InstrumentState_STATE_FAULT;
    make_safe(motion, failed_mask);
    motion->port->log.write(motion->port->log.context, GN_LOG_ERROR, fault->sentence);
    if (!first) {
        gn_notice_log(motion, GN_LOG_WARNING, fault->sentence);
        gn_ride_halt(motion, gonio_PathEnd_PATH_FAULT);
        return;
    }
    motion->last_fault = *fault;
    gn_event(motion, &event);
    gn_operation_done(motion, gonio_ReplyCode_REPLY_FAULT, motion->last_fault.sentence);
    gn_ride_halt(motion, gonio_PathEnd_PATH_FAULT);
}
