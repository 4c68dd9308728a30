/* cycle.c: the SYNC cycle: close the pose, step the path, send SYNC, and after its echo the RPDOs for the next SYNC. */
#include "cycle.h"

#include "homing.h"
#include "monitor.h"
#include "notice.h"
#include "operation.h"
#include "outputs.h"
#include "ride.h"

/* After this part of the period the RPDOs go out even if the SYNC's echo did not come: the drives watch their deadline.
 */
static int64_t rpdo_due_ns(const struct gn_motion *motion) {
    return motion->sync.sent_ns + gn_cycle_period_ns(motion) / 2;
}

static void send_rpdos(struct gn_motion *motion) {
    motion->rpdo_pending = false;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        struct gn_axis *axis = &motion->axes[i];
        struct gn_can_frame frame;
        /* A drive that does not hold a position is told the one it has, so that enabling it never moves it. */
        if (!axis->enabled || gn_homing_active(axis) || axis->drive.mode != GN_MODE_CSP) {
            if (!axis->failed) {
                axis->target_counts = axis->measured_counts;
            }
        }
        struct gn_pdo_command const command = {
            .controlword = gn_drive_command(&axis->drive),
            .target_counts = axis->target_counts,
            .mode = axis->drive.mode,
        };
        gn_pdo_pack(&axis->rpdo, axis->config.node, &command, &frame);
        (void)motion->port->can.send(motion->port->can.context, &frame);
    }
}

static void on_tpdo(struct gn_motion *motion, uint32_t i, const struct gn_can_frame *frame) {
    struct gn_axis *axis = &motion->axes[i];
    int32_t position = 0;
    if (!motion->sync_running || !gn_pdo_unpack(&axis->tpdo, frame, &axis->drive.statusword, &position)) {
        return;
    }
    axis->drive.seen = true;
    axis->measured = true;
    axis->measured_counts = position;
    (void)gn_sync_on_tpdo(&motion->sync, i, position, frame->stamp_ns);
    gn_monitor_drive(motion, i);
}

static void dispatch(struct gn_motion *motion, const struct gn_can_frame *frame) {
    if (frame->own_echo) {
        if (frame->id == GN_SYNC_COB && gn_sync_on_echo(&motion->sync, frame) && motion->rpdo_pending) {
            send_rpdos(motion);
        }
        return;
    }
    uint32_t const function = frame->id & ~0x7Fu;
    uint32_t const node = frame->id & 0x7Fu;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        struct gn_axis *axis = &motion->axes[i];
        if (!axis->configured || axis->config.node != node) {
            continue;
        }
        if (function == GN_SYNC_COB) {
            gn_monitor_emergency(motion, i, frame);
        } else if (function == GN_TPDO1) {
            on_tpdo(motion, i, frame);
        } else if (function == 0x580u) {
            gn_sdo_on_frame(&axis->sdo, &motion->port->can, frame, motion->now_ns);
        } else if (function == 0x700u) {
            gn_node_on_frame(&axis->node, frame, motion->now_ns);
        }
        return;
    }
}

void gn_frames_process(struct gn_motion *motion) {
    struct gn_can_frame frame;
    while (motion->port->can.receive(motion->port->can.context, &frame)) {
        dispatch(motion, &frame);
        gn_operation_process(motion); /* boot sends its next request as soon as an answer came */
    }
}

static void send_sync(struct gn_motion *motion) {
    struct gn_can_frame frame;
    gn_sync_begin(&motion->sync, motion->now_ns, &frame);
    (void)motion->port->can.send(motion->port->can.context, &frame);
    motion->rpdo_pending = true;
}

static void run_cycle(struct gn_motion *motion) {
    struct gn_pose pose;
    if (motion->rpdo_pending) { /* the call came too late for them to go out by themselves */
        send_rpdos(motion);
    }
    if (gn_sync_close(&motion->sync, gn_known_mask(motion), &pose)) {
        (void)gn_ring_push(&motion->shared->poses, &pose); /* the ring counts what it drops */
    }
    gn_heartbeat_process(&motion->heartbeat, &motion->port->can, motion->now_ns);
    gn_monitor_nodes(motion);
    gn_monitor_bus(motion);
    gn_operation_cycle(motion);
    gn_ride_step(motion);
    gn_shutter_process(motion);
    if (motion->sync_running) {
        send_sync(motion);
    }
    if (motion->state != gonio_InstrumentState_STATE_FAULT) {
        motion->port->out.pulse_watchdog(motion->port->out.context);
    }
}

void gn_cycle_process(struct gn_motion *motion) {
    if (!motion->configured) {
        return;
    }
    if (motion->rpdo_pending && motion->now_ns >= rpdo_due_ns(motion)) {
        send_rpdos(motion);
    }
    if (motion->now_ns < motion->next_cycle_ns) {
        return;
    }
    int64_t const period_ns = gn_cycle_period_ns(motion);
    int64_t const missed = (motion->now_ns - motion->next_cycle_ns) / period_ns;
    uint32_t *const counter = &motion->shared->counters.cycles_missed;
    __atomic_store_n(counter, *counter + (uint32_t)missed, __ATOMIC_RELAXED);
    motion->next_cycle_ns += (missed + 1) * period_ns; /* what was slept through is left out; the grid stays */
    run_cycle(motion);
}

int64_t gn_cycle_next_ns(const struct gn_motion *motion) {
    if (!motion->configured) {
        return GN_NEVER_NS;
    }
    return motion->rpdo_pending && rpdo_due_ns(motion) < motion->next_cycle_ns ? rpdo_due_ns(motion)
                                                                               : motion->next_cycle_ns;
}
