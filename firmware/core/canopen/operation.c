/* operation.c: Boot, Home, ClearFault and Release over all axes. */
#include "operation.h"

#include <stdio.h>

#include "boot.h"
#include "fault.h"
#include "homing.h"
#include "input_lines.h"
#include "monitor.h"
#include "notice.h"

#define MOTION_STATE(name) gonio_InstrumentState_STATE_##name

static void refuse(struct gn_motion *motion, uint32_t request_id, const char *why) {
    gn_reply(motion, request_id, gonio_ReplyCode_REPLY_REFUSED, why);
}

static void accept(struct gn_motion *motion, uint32_t request_id, enum gn_operation_kind kind) {
    motion->operation = (struct gn_operation){
        .kind = kind,
        .request_id = request_id,
        .deadline_ns = motion->now_ns + (int64_t)motion->cycle.boot_timeout_ms * 1000000,
    };
    gn_reply(motion, request_id, gonio_ReplyCode_REPLY_ACCEPTED, "");
}

/* Another operation, or an SdoRead, needs the SDO clients; if so, replies. */
static bool busy(struct gn_motion *motion, uint32_t request_id) {
    if (motion->operation.kind == GN_OPERATION_NONE && !motion->errand.pending) {
        return false;
    }
    refuse(motion, request_id, "another operation is under way: wait for its end");
    return true;
}

static bool any_enabled(const struct gn_motion *motion) {
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        if (motion->axes[i].enabled) {
            return true;
        }
    }
    return false;
}

/* What forbids movement: an input, or the bus. NULL: nothing. */
static const char *obstacle_of(const struct gn_motion *motion) {
    const char *input = gn_inputs_obstacle(motion);
    return input != NULL ? input : gn_monitor_bus_obstacle(motion);
}

void gn_boot_request(struct gn_motion *motion, uint32_t request_id) {
    if (motion->state == MOTION_STATE(UNCONFIGURED)) {
        char why[120];
        uint32_t missing = 0;
        while (motion->configured && motion->axes[missing].configured) {
            missing++;
        }
        (void)snprintf(why, sizeof why, "%s was not received: send Configure and every AxisConfig before Boot",
                       motion->configured ? (const char *[]){"AxisConfig of axis 0", "AxisConfig of axis 1",
                                                             "AxisConfig of axis 2", "AxisConfig of axis 3"}[missing]
                                          : "Configure");
        refuse(motion, request_id, why);
        return;
    }
    if ((motion->state != MOTION_STATE(CONFIGURED) && motion->state != MOTION_STATE(UNHOMED)) || any_enabled(motion)) {
        refuse(motion, request_id, "the drives are in use: release them (or clear the fault) before Boot");
        return;
    }
    if (busy(motion, request_id)) {
        return;
    }
    const char *obstacle = gn_monitor_bus_obstacle(motion);
    if (obstacle != NULL) {
        refuse(motion, request_id, obstacle);
        return;
    }
    accept(motion, request_id, GN_OPERATION_BOOT);
    motion->state = MOTION_STATE(BOOTING);
    motion->sync_running = false;
    gn_sync_init(&motion->sync, (int64_t)motion->cycle.sync_window_us * 1000, &motion->shared->counters);
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        gn_boot_begin(&motion->axes[i]);
    }
}

/* What checks on receipt hold the axis to, now that its drive is known. */
static void set_limits(struct gn_motion *motion, uint32_t i) {
    const struct gn_axis *axis = &motion->axes[i];
    struct gn_axis_limits limits = {
        .min_counts = axis->config.min_counts,
        .max_counts = axis->config.max_counts,
        .max_velocity_counts_per_s = axis->config.max_velocity_counts_per_s,
        .max_acceleration_counts_per_s2 = axis->config.max_acceleration_counts_per_s2,
    };
    double const unguarded = axis->unguarded_counts_per_s;
    if (unguarded > 0.0 && unguarded < limits.max_velocity_counts_per_s) {
        limits.max_velocity_counts_per_s = unguarded;
        limits.velocity_reason =
            "its drive has no 0x1400:05 (see info): lower max_velocity_deg_per_s, or change the drive";
    }
    gn_path_set_limits(&motion->path, i, &limits);
}

static void boot_process(struct gn_motion *motion) {
    struct gn_bus const bus = gn_motion_bus(motion);
    uint32_t configured = 0;
    uint32_t done = 0;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        struct gn_trouble trouble = {0};
        enum gn_boot_progress const progress = gn_boot_process(&motion->axes[i], &bus, &trouble);
        if (progress == GN_BOOT_FAILED) {
            gn_fault_raise(motion, i, 1u << i, &trouble);
            return;
        }
        configured += progress == GN_BOOT_CONFIGURED ? 1u : 0u;
        done += progress == GN_BOOT_DONE ? 1u : 0u;
    }
    if (configured == motion->cycle.axis_count) {
        motion->sync_running = true;
        for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
            motion->axes[i].boot.start_allowed = true;
        }
    } else if (done == motion->cycle.axis_count) {
        motion->sync.expected_mask = gn_all_axes(motion);
        for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
            set_limits(motion, i);
        }
        motion->state = MOTION_STATE(UNHOMED);
        gn_operation_done(motion, gonio_ReplyCode_REPLY_OK, "");
    }
}

void gn_home_request(struct gn_motion *motion, uint32_t request_id, uint32_t axis_mask) {
    if (motion->state != MOTION_STATE(UNHOMED) && motion->state != MOTION_STATE(READY)) {
        refuse(motion, request_id, "homing needs booted drives at rest: boot them, or stop the motion first");
        return;
    }
    if (busy(motion, request_id)) {
        return;
    }
    if (axis_mask == 0u || (axis_mask & ~gn_all_axes(motion)) != 0u) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_INVALID,
                 "the axis mask names no axis, or one that is not in use");
        return;
    }
    const char *obstacle = obstacle_of(motion);
    if (obstacle != NULL) {
        refuse(motion, request_id, obstacle);
        return;
    }
    accept(motion, request_id, GN_OPERATION_HOME);
    motion->operation.axis_mask = axis_mask;
    motion->state = MOTION_STATE(HOMING);
}

/* The axes of lowest order among those still to be homed. */
static uint32_t next_group(const struct gn_motion *motion) {
    uint32_t lowest = UINT32_MAX;
    uint32_t group = 0;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        uint32_t const order = motion->axes[i].config.homing_order;
        if ((motion->operation.axis_mask & 1u << i) == 0u || (group != 0u && order > lowest)) {
            continue;
        }
        group = (group != 0u && order == lowest) ? group | 1u << i : 1u << i;
        lowest = order;
    }
    return group;
}

static void home_cycle(struct gn_motion *motion) {
    struct gn_bus const bus = gn_motion_bus(motion);
    uint32_t const group = next_group(motion);
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        struct gn_axis *axis = &motion->axes[i];
        struct gn_trouble trouble = {0};
        if ((group & 1u << i) == 0u) {
            continue;
        }
        if (axis->homing.phase == GN_HOMING_OFF) {
            gn_homing_begin(axis, motion->now_ns);
        }
        enum gn_homing_progress const progress = gn_homing_process(axis, &bus, &trouble);
        if (progress == GN_HOMING_FAILED) {
            gn_fault_raise(motion, i, 1u << i, &trouble);
            return;
        }
        if (progress == GN_HOMING_FINISHED) {
            axis->homing.phase = GN_HOMING_OFF;
            motion->operation.axis_mask &= ~(1u << i);
        }
    }
    if (motion->operation.axis_mask == 0u) {
        bool const all = gn_known_mask(motion) == gn_all_axes(motion);
        motion->state = all ? MOTION_STATE(READY) : MOTION_STATE(UNHOMED);
        gn_operation_done(motion, gonio_ReplyCode_REPLY_OK, "");
    }
}

void gn_home_halt(struct gn_motion *motion, const char *why) {
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        if (gn_homing_active(&motion->axes[i])) {
            gn_homing_halt(&motion->axes[i]);
        }
    }
    motion->state = MOTION_STATE(UNHOMED);
    gn_operation_done(motion, gonio_ReplyCode_REPLY_REFUSED, why);
}

/* Down to switch-on disabled; a gravity axis keeps its torque until its brake is on. */
static void release_all(struct gn_motion *motion) {
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        struct gn_axis *axis = &motion->axes[i];
        axis->enabled = false;
        axis->homed = false;
        axis->drive.operation_bits = 0;
        axis->drive.goal = axis->config.gravity ? GN_GOAL_RELEASED_BY_STOP : GN_GOAL_RELEASED;
    }
}

void gn_clear_fault_request(struct gn_motion *motion, uint32_t request_id) {
    if (motion->state != MOTION_STATE(FAULT)) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_OK, "");
        return;
    }
    const char *obstacle = obstacle_of(motion);
    if (obstacle != NULL || motion->path.state != GN_PATH_IDLE || motion->operation.kind != GN_OPERATION_NONE) {
        refuse(motion, request_id, obstacle != NULL ? obstacle : "the axes are still stopping: try again in a second");
        return;
    }
    accept(motion, request_id, GN_OPERATION_CLEAR_FAULT);
    release_all(motion);
}

void gn_release_request(struct gn_motion *motion, uint32_t request_id) {
    if ((motion->state != MOTION_STATE(READY) && motion->state != MOTION_STATE(UNHOMED)) ||
        motion->operation.kind != GN_OPERATION_NONE) {
        refuse(motion, request_id, "release needs booted drives at rest: stop the motion, or clear the fault first");
        return;
    }
    accept(motion, request_id, GN_OPERATION_RELEASE);
    motion->state = MOTION_STATE(UNHOMED);
    release_all(motion);
}

/* Nodes that are gone cannot be released; the next boot finds out. */
static bool reachable(const struct gn_motion *motion, const struct gn_axis *axis) {
    return motion->sync_running && axis->boot.operational && axis->node.monitored;
}

static void release_cycle(struct gn_motion *motion) {
    bool const clearing = motion->operation.kind == GN_OPERATION_CLEAR_FAULT;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        const struct gn_axis *axis = &motion->axes[i];
        if (!reachable(motion, axis) || gn_drive_at_goal(&axis->drive)) {
            continue;
        }
        if (motion->now_ns < motion->operation.deadline_ns) {
            return;
        }
        char text[200];
        (void)snprintf(text, sizeof text,
                       "%.23s (node %u) does not release, 0x6041 (statusword) 0x%04X: %s; read 0x603F",
                       axis->config.name, (unsigned)axis->config.node, axis->drive.statusword,
                       gn_drive_state_words(gn_drive_state_of(axis->drive.statusword)));
        gn_operation_done(motion, gonio_ReplyCode_REPLY_FAULT, text);
        return;
    }
    if (clearing) {
        for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
            motion->axes[i].failed = false;
            motion->axes[i].node.monitored = false; /* the next boot watches them again */
        }
        motion->state = MOTION_STATE(CONFIGURED);
    }
    gn_operation_done(motion, gonio_ReplyCode_REPLY_OK, "");
}

void gn_operation_process(struct gn_motion *motion) {
    if (motion->operation.kind == GN_OPERATION_BOOT) {
        boot_process(motion);
    }
}

void gn_operation_cycle(struct gn_motion *motion) {
    if (motion->operation.kind == GN_OPERATION_HOME) {
        home_cycle(motion);
    } else if (motion->operation.kind == GN_OPERATION_CLEAR_FAULT || motion->operation.kind == GN_OPERATION_RELEASE) {
        release_cycle(motion);
    }
}
