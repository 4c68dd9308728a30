/* ride.c: drives the path from the SYNC cycle and reports its start and end. */
#include "ride.h"

#include <math.h>
#include <stdio.h>

#include "fault.h"
#include "input_lines.h"
#include "log.h"
#include "notice.h"
#include "outputs.h"

/* The shutter's own travel. */
#define SHUTTER_MS 50u

uint32_t gn_ride_stop_ms(const gonio_Configure *cycle) {
    uint32_t const cycle_ms = (cycle->sync_period_us + 999u) / 1000u;
    return GN_PATH_HOLD_MS + GN_DARK_DEADLINE_MS + SHUTTER_MS + 2u * cycle_ms;
}

int64_t gn_ride_patience_ns(const gonio_Configure *cycle) {
    return ((int64_t)cycle->expiry_ms - gn_ride_stop_ms(cycle)) * 1000000;
}

static void finish(struct gn_motion *motion, gonio_PathEnd end) {
    gn_event_path(motion, end);
    gn_path_drop(&motion->path);
    motion->ride = (struct gn_ride){0};
    if (motion->state == gonio_InstrumentState_STATE_MOVING || motion->state == gonio_InstrumentState_STATE_STOPPING) {
        motion->state = gonio_InstrumentState_STATE_READY;
    }
}

static bool any_follows(const struct gn_motion *motion) {
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        if (motion->axes[i].enabled) {
            return true;
        }
    }
    return false;
}

void gn_ride_halt(struct gn_motion *motion, gonio_PathEnd end) {
    if (motion->path.state == GN_PATH_IDLE) {
        return;
    }
    if (end != gonio_PathEnd_PATH_FAULT) {
        gn_shutter_close_when_still(motion);
    }
    if (motion->path.state == GN_PATH_BUFFERING || !any_follows(motion)) {
        finish(motion, end);
        return;
    }
    gn_path_hold(&motion->path);
    if (!motion->ride.halted || end == gonio_PathEnd_PATH_FAULT) {
        motion->ride.halted = true;
        motion->ride.end = end;
    }
    if (motion->state == gonio_InstrumentState_STATE_MOVING) {
        motion->state = gonio_InstrumentState_STATE_STOPPING;
    }
}

void gn_ride_begin(struct gn_motion *motion, const gonio_Request *request) {
    const gonio_MotionBegin *begin = &request->body.motion_begin;
    char why[160] = "";
    if (motion->state == gonio_InstrumentState_STATE_MOVING && motion->path.path_id == begin->path_id && begin->start) {
        motion->ride.start = true;
        gn_reply(motion, request->id, gonio_ReplyCode_REPLY_OK, "");
        return;
    }
    if (motion->state != gonio_InstrumentState_STATE_READY) {
        gn_reply(motion, request->id, gonio_ReplyCode_REPLY_REFUSED,
                 "a path begins when the axes are homed and hold still: wait for the end of the last path, or home");
        return;
    }
    const char *obstacle = gn_inputs_path_obstacle(motion);
    if (obstacle != NULL) {
        gn_reply(motion, request->id, gonio_ReplyCode_REPLY_REFUSED, obstacle);
        return;
    }
    if (!gn_path_begin(&motion->path, begin->path_id, begin->knot_count, why, sizeof why)) {
        gn_reply(motion, request->id, gonio_ReplyCode_REPLY_REFUSED, why);
        return;
    }
    motion->ride = (struct gn_ride){.start = begin->start};
    motion->dark_when_still = false;
    motion->state = gonio_InstrumentState_STATE_MOVING;
    gn_reply(motion, request->id, gonio_ReplyCode_REPLY_OK, "");
}

/* A refused knot ends the path in a controlled stop: nothing is wrong with the drives. */
static void refuse_knot(struct gn_motion *motion, const char *why) {
    gn_notice_log(motion, GN_LOG_ERROR, why);
    if (motion->path.state == GN_PATH_IDLE) { /* dropped before it ran */
        finish(motion, gonio_PathEnd_PATH_STOPPED);
    } else {
        gn_ride_halt(motion, gonio_PathEnd_PATH_STOPPED);
    }
}

void gn_ride_take_knots(struct gn_motion *motion, uint32_t count) {
    struct gn_knot_item item;
    double standing[GN_AXES] = {0};
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        standing[i] = motion->axes[i].target_counts;
    }
    for (; count > 0u && gn_ring_pop(&motion->shared->knots, &item); count--) {
        char why[160] = "";
        bool const wanted = motion->state == gonio_InstrumentState_STATE_MOVING && !motion->ride.halted &&
                            item.path_id == motion->path.path_id;
        /* Knots of a path that has ended were under way when it did. */
        if (wanted && !gn_path_push(&motion->path, item.number, &item.knot, standing, why, sizeof why)) {
            refuse_knot(motion, why);
        }
    }
}

static void underran(struct gn_motion *motion) {
    /* Slowing down took a good while: if the host said nothing meanwhile, it is gone, not slow. */
    if (motion->heard_ns < motion->ride.underrun_ns) {
        gn_shutter_close_when_still(motion);
        finish(motion, gonio_PathEnd_PATH_EXPIRED);
        return;
    }
    struct gn_trouble trouble = {
        .code = gonio_FaultCode_FAULT_UNDERRUN,
        .remedy = "keep more knots buffered, clear the fault and home",
    };
    (void)snprintf(trouble.cause, sizeof trouble.cause, "path %lu ran out of knots at %.3f s, %lu of %lu received",
                   (unsigned long)motion->path.path_id, (double)motion->path.time_ns * 1e-9,
                   (unsigned long)motion->path.received, (unsigned long)motion->path.knot_count);
    finish(motion, gonio_PathEnd_PATH_FAULT);
    gn_fault_raise(motion, GN_NO_AXIS, 0, &trouble);
}

void gn_ride_step(struct gn_motion *motion) {
    struct gn_path *path = &motion->path;
    double targets[GN_AXES] = {0};
    bool underrun = false;
    if (path->state == GN_PATH_IDLE || (path->state == GN_PATH_BUFFERING && !motion->ride.start)) {
        return;
    }
    gn_path_step(path, gn_cycle_period_ns(motion), targets, &underrun);
    if (path->state == GN_PATH_IDLE || path->state == GN_PATH_BUFFERING) {
        return;
    }
    if (!motion->ride.announced) {
        motion->ride.announced = true;
        gn_event_path(motion, gonio_PathEnd_PATH_RUNNING);
    }
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        if (motion->axes[i].enabled) {
            motion->axes[i].target_counts = (int32_t)lround(targets[i]);
        }
    }
    if (underrun && motion->ride.underrun_ns == 0) {
        motion->ride.underrun_ns = motion->now_ns;
    } else if (path->feed >= 1.0) {
        motion->ride.underrun_ns = 0; /* knots came in time */
    }
    if (path->state == GN_PATH_DONE) {
        finish(motion, motion->state == gonio_InstrumentState_STATE_FAULT ? gonio_PathEnd_PATH_FAULT
                                                                          : gonio_PathEnd_PATH_FINISHED);
    } else if (path->state == GN_PATH_HELD && motion->ride.halted) {
        finish(motion, motion->ride.end);
    } else if (path->state == GN_PATH_HELD) {
        underran(motion);
    }
}
