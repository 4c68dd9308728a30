/* homing.c: mode 6 and back to mode 8, each change of mode read back before the axis moves. */
#include "homing.h"

#include <stdio.h>

/* A drive shows "in progress" two SYNCs after the start bit; until this many have passed, an old "attained" may stand.
 */
#define START_SETTLE_SYNCS 10

static void enter(struct gn_axis *axis, enum gn_homing_phase phase, int64_t now_ns) {
    axis->homing.phase = phase;
    axis->homing.began_ns = now_ns;
    gn_sdo_reset(&axis->sdo);
}

void gn_homing_begin(struct gn_axis *axis, int64_t now_ns) {
    axis->homed = false;
    axis->drive.operation_bits = 0;
    axis->homing = (struct gn_homing){0};
    enter(axis, GN_HOMING_SET_MODE, now_ns);
}

bool gn_homing_active(const struct gn_axis *axis) {
    return axis->homing.phase != GN_HOMING_OFF && axis->homing.phase != GN_HOMING_DONE;
}

void gn_homing_halt(struct gn_axis *axis) {
    axis->homing.phase = GN_HOMING_OFF;
    axis->drive.operation_bits = GN_CONTROL_HALT;
}

static bool overdue(const struct gn_axis *axis, const struct gn_bus *bus, uint32_t timeout_ms) {
    return bus->now_ns - axis->homing.began_ns > (int64_t)timeout_ms * 1000000;
}

static enum gn_homing_progress fail(struct gn_trouble *trouble, uint16_t index, const char *remedy) {
    trouble->code = gonio_FaultCode_FAULT_HOMING;
    trouble->index = index;
    trouble->remedy = remedy;
    return GN_HOMING_FAILED;
}

static enum gn_homing_progress sdo_failed(struct gn_axis *axis, struct gn_trouble *trouble) {
    gn_trouble_from_sdo(trouble, &axis->sdo, axis->sdo.upload ? "mode display" : "mode");
    return GN_HOMING_FAILED;
}

static enum gn_homing_progress set_mode(struct gn_axis *axis, const struct gn_bus *bus, int8_t mode,
                                        struct gn_trouble *trouble) {
    switch (axis->sdo.state) {
    case GN_SDO_IDLE:
        axis->drive.mode = mode;
        (void)gn_sdo_write(&axis->sdo, bus->can, 0x6060, 0, (uint8_t)mode, 1, bus->now_ns);
        return GN_HOMING_RUNNING;
    case GN_SDO_BUSY:
        return GN_HOMING_RUNNING;
    case GN_SDO_DONE:
        return GN_HOMING_FINISHED;
    case GN_SDO_ABORTED:
    case GN_SDO_TIMED_OUT:
        break;
    }
    return sdo_failed(axis, trouble);
}

/* Reads 0x6061 again and again: a drive may take some cycles to change its mode. */
static enum gn_homing_progress check_mode(struct gn_axis *axis, const struct gn_bus *bus, int8_t mode,
                                          struct gn_trouble *trouble) {
    if (axis->sdo.state == GN_SDO_BUSY) {
        return GN_HOMING_RUNNING;
    }
    if (axis->sdo.state == GN_SDO_ABORTED || axis->sdo.state == GN_SDO_TIMED_OUT) {
        return sdo_failed(axis, trouble);
    }
    if (axis->sdo.state == GN_SDO_DONE && (int8_t)gn_sdo_value(&axis->sdo) == mode) {
        return GN_HOMING_FINISHED;
    }
    if (overdue(axis, bus, bus->cycle->boot_timeout_ms)) {
        (void)snprintf(trouble->cause, sizeof trouble->cause, "0x6061 (mode display) did not become %d", mode);
        return fail(trouble, 0x6061, "check that the drive supports modes 6 and 8");
    }
    (void)gn_sdo_read(&axis->sdo, bus->can, 0x6061, 0, bus->now_ns);
    return GN_HOMING_RUNNING;
}

static enum gn_homing_progress enable(struct gn_axis *axis, const struct gn_bus *bus, struct gn_trouble *trouble) {
    axis->drive.goal = GN_GOAL_ENABLED;
    if (gn_drive_at_goal(&axis->drive)) {
        axis->enabled = true;
        axis->drive.operation_bits = GN_CONTROL_HOMING_START;
        return GN_HOMING_FINISHED;
    }
    if (overdue(axis, bus, bus->cycle->boot_timeout_ms)) {
        (void)snprintf(trouble->cause, sizeof trouble->cause, "not enabled, 0x6041 (statusword) 0x%04X: %s",
                       axis->drive.statusword, gn_drive_state_words(gn_drive_state_of(axis->drive.statusword)));
        return fail(trouble, 0x6041, "check STO, motor supply and 0x603F");
    }
    return GN_HOMING_RUNNING;
}

static enum gn_homing_progress move(struct gn_axis *axis, const struct gn_bus *bus, struct gn_trouble *trouble) {
    struct gn_homing *homing = &axis->homing;
    uint16_t const status = axis->drive.statusword;
    bool const attained = (status & GN_STATUS_HOMING_ATTAINED) != 0;
    bool const reached = (status & GN_STATUS_TARGET_REACHED) != 0;
    bool const error = (status & GN_STATUS_HOMING_ERROR) != 0;
    bool const settled =
        bus->now_ns - homing->began_ns >= (int64_t)START_SETTLE_SYNCS * bus->cycle->sync_period_us * 1000;
    homing->began = homing->began || (!attained && !reached && !error);
    if (!homing->began && !settled) {
        return GN_HOMING_RUNNING;
    }
    if (error) {
        (void)snprintf(trouble->cause, sizeof trouble->cause, "homing error, 0x6041 (statusword) 0x%04X, method %ld",
                       status, (long)axis->config.homing_method);
        return fail(trouble, 0x6041, "check which way it went, switch, index pulse and 0x6098");
    }
    if (attained && reached) {
        axis->drive.operation_bits = 0;
        return GN_HOMING_FINISHED;
    }
    if (overdue(axis, bus, axis->config.homing_timeout_ms)) {
        (void)snprintf(trouble->cause, sizeof trouble->cause, "homing (0x6098 method %ld) not finished within %u ms",
                       (long)axis->config.homing_method, (unsigned)axis->config.homing_timeout_ms);
        return fail(trouble, 0x6098, "if it went the wrong way check its wiring and sign, else switch and 0x6099");
    }
    return GN_HOMING_RUNNING;
}

enum gn_homing_progress gn_homing_process(struct gn_axis *axis, const struct gn_bus *bus, struct gn_trouble *trouble) {
    enum gn_homing_progress progress = GN_HOMING_FINISHED;
    gn_sdo_process(&axis->sdo, bus->can, bus->now_ns);
    switch (axis->homing.phase) {
    case GN_HOMING_OFF:
    case GN_HOMING_DONE:
        return GN_HOMING_FINISHED;
    case GN_HOMING_SET_MODE:
        progress = set_mode(axis, bus, GN_MODE_HOMING, trouble);
        break;
    case GN_HOMING_CHECK_MODE:
        progress = check_mode(axis, bus, GN_MODE_HOMING, trouble);
        break;
    case GN_HOMING_ENABLE:
        progress = enable(axis, bus, trouble);
        break;
    case GN_HOMING_MOVE:
        progress = move(axis, bus, trouble);
        break;
    case GN_HOMING_SET_CSP:
        progress = set_mode(axis, bus, GN_MODE_CSP, trouble);
        break;
    case GN_HOMING_CHECK_CSP:
        progress = check_mode(axis, bus, GN_MODE_CSP, trouble);
        break;
    }
    if (progress != GN_HOMING_FINISHED) {
        return progress;
    }
    enter(axis, (enum gn_homing_phase)(axis->homing.phase + 1), bus->now_ns);
    if (axis->homing.phase != GN_HOMING_DONE) {
        return GN_HOMING_RUNNING;
    }
    axis->homed = true;
    return GN_HOMING_FINISHED;
}
