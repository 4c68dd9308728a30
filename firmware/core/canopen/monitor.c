/* monitor.c: turns what the drives say, or fail to say, into faults. */
#include "monitor.h"

#include <stddef.h>
#include <stdio.h>

#include "emergency.h"
#include "fault.h"
#include "log.h"
#include "notice.h"

/* Ten milliseconds of SYNCs that nobody saw, while drives quick-stop after three without an RPDO: the bus is gone. */
#define ECHO_LIMIT 5u

static void node_trouble(struct gn_motion *motion, uint32_t i, gonio_FaultCode code, uint16_t index, const char *cause,
                         const char *remedy) {
    struct gn_trouble trouble = {.code = code, .index = index, .remedy = remedy};
    (void)snprintf(trouble.cause, sizeof trouble.cause, "%s", cause);
    motion->axes[i].node.monitored = false; /* once is enough */
    gn_fault_raise(motion, i, 1u << i, &trouble);
}

void gn_monitor_nodes(struct gn_motion *motion) {
    int64_t const timeout_ns = (int64_t)motion->cycle.heartbeat_timeout_ms * 1000000;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        struct gn_axis *axis = &motion->axes[i];
        char cause[80];
        if (axis->node.reset) {
            axis->node.reset = false;
            node_trouble(motion, i, gonio_FaultCode_FAULT_NODE_RESET, 0, "unexpected boot-up message",
                         "check its supply, then boot and home");
        } else if (gn_node_lost(&axis->node, timeout_ns, motion->now_ns)) {
            (void)snprintf(cause, sizeof cause, "no heartbeat (0x1017) for %u ms",
                           (unsigned)motion->cycle.heartbeat_timeout_ms);
            node_trouble(motion, i, gonio_FaultCode_FAULT_NODE_LOST, 0x1017, cause,
                         "check power and cable, then boot and home");
        } else if (axis->node.monitored && axis->boot.operational && axis->node.nmt_state != GN_NMT_STATE_OPERATIONAL) {
            (void)snprintf(cause, sizeof cause, "became %s by itself", gn_nmt_state_words(axis->node.nmt_state));
            node_trouble(motion, i, gonio_FaultCode_FAULT_DRIVE_STATE, 0, cause, "check the bus, then boot and home");
        }
    }
}

static void store(uint32_t *counter, uint32_t value) {
    __atomic_store_n(counter, value, __ATOMIC_RELAXED);
}

static void count_bus(struct gn_motion *motion, const struct gn_can_status *status) {
    struct gn_motion_counters *counters = &motion->shared->counters;
    store(&counters->can_overflow, status->receive_overflows);
    store(&counters->can_error_frames, status->error_frames);
    store(&counters->can_setpoints_dropped, status->setpoints_dropped);
    store(&counters->can_bus_offs, status->bus_offs);
    store(&counters->clock_steps, status->clock_steps);
    float sigma_us = status->sync_stamp_sigma_us;
    __atomic_store(&motion->shared->sync_stamp_sigma_us, &sigma_us, __ATOMIC_RELAXED);
}

/* Error passive is a bus that still works, badly: told once, until all is well again. */
static void watch_passive(struct gn_motion *motion, const struct gn_can_status *status) {
    bool const passive = status->state == GN_CAN_ERROR_PASSIVE;
    if (passive && !motion->bus_passive) {
        char text[160];
        (void)snprintf(text, sizeof text,
                       "CAN error passive after %u error frames: frames are damaged or nobody acknowledges them; check "
                       "terminators, cable and bit rate",
                       (unsigned)status->error_frames);
        motion->port->log.write(motion->port->log.context, GN_LOG_WARNING, text);
        gn_notice_log(motion, GN_LOG_WARNING, text);
    }
    motion->bus_passive = passive || (motion->bus_passive && status->state != GN_CAN_ERROR_ACTIVE);
}

/* What is wrong with the bus itself; "" where nothing is. */
static void bus_cause(const struct gn_motion *motion, const struct gn_can_status *status, char *cause, uint32_t size) {
    cause[0] = '\0';
    if (status->state == GN_CAN_DOWN) {
        (void)snprintf(cause, size, "the CAN interface is down or gone");
    } else if (status->state == GN_CAN_BUS_OFF || status->bus_offs != motion->bus_offs_seen) {
        (void)snprintf(cause, size, "CAN bus off after %u error frames", (unsigned)status->error_frames);
    }
}

static const char *bus_remedy(const struct gn_can_status *status) {
    return status->state == GN_CAN_DOWN ? "plug it in and bring it up, then clear the fault, boot and home"
                                        : "check cable, terminators and bit rate, then clear the fault, boot and home";
}

void gn_monitor_bus(struct gn_motion *motion) {
    struct gn_can_status status = {0};
    struct gn_trouble trouble = {.code = gonio_FaultCode_FAULT_CAN};
    motion->port->can.status(motion->port->can.context, &status);
    count_bus(motion, &status);
    watch_passive(motion, &status);
    bus_cause(motion, &status, trouble.cause, sizeof trouble.cause);
    motion->bus_offs_seen = status.bus_offs;
    bool const booting = motion->state == gonio_InstrumentState_STATE_BOOTING;
    if (motion->state == gonio_InstrumentState_STATE_FAULT || (!motion->sync_running && !booting)) {
        return;
    }
    trouble.remedy = bus_remedy(&status);
    if (trouble.cause[0] == '\0') {
        if (motion->sync.echoes_lost_in_a_row < ECHO_LIMIT) {
            return;
        }
        (void)snprintf(trouble.cause, sizeof trouble.cause, "%u SYNCs (0x080) in a row did not come back from the bus",
                       (unsigned)motion->sync.echoes_lost_in_a_row);
        trouble.remedy = "check the CAN interface and its cable, then boot and home";
    }
    gn_fault_raise(motion, GN_NO_AXIS, 0, &trouble);
}

const char *gn_monitor_bus_obstacle(const struct gn_motion *motion) {
    struct gn_can_status status = {0};
    motion->port->can.status(motion->port->can.context, &status);
    if (status.state == GN_CAN_DOWN) {
        return "the CAN interface is down or gone: plug it in and bring it up";
    }
    return status.state == GN_CAN_BUS_OFF ? "the CAN bus is off: check cable, terminators and bit rate" : NULL;
}

void gn_monitor_drive(struct gn_motion *motion, uint32_t i) {
    struct gn_axis *axis = &motion->axes[i];
    uint16_t const status = axis->drive.statusword;
    enum gn_drive_state const state = gn_drive_state_of(status);
    struct gn_trouble trouble = {.index = 0x6041};
    if (!axis->enabled) {
        return;
    }
    if (state != GN_DRIVE_OPERATION_ENABLED) {
        trouble.code = gonio_FaultCode_FAULT_DRIVE_STATE;
        (void)snprintf(trouble.cause, sizeof trouble.cause, "left operation enabled, 0x6041 (statusword) 0x%04X: %s",
                       status, gn_drive_state_words(state));
        trouble.remedy = "read 0x603F, clear and home";
    } else if (axis->drive.mode == GN_MODE_CSP && axis->homed && (status & GN_STATUS_FOLLOWING_ERROR)) {
        trouble.code = gonio_FaultCode_FAULT_FOLLOWING_ERROR;
        trouble.index = 0x6065;
        (void)snprintf(trouble.cause, sizeof trouble.cause, "following error beyond 0x6065 (%lu counts)",
                       (unsigned long)axis->config.following_error_counts);
        trouble.remedy = "free the axis or lower the speed, clear and home";
    } else {
        return;
    }
    gn_fault_raise(motion, i, 1u << i, &trouble);
}

void gn_monitor_emergency(struct gn_motion *motion, uint32_t i, const struct gn_can_frame *frame) {
    struct gn_axis *axis = &motion->axes[i];
    if (!axis->node.monitored || frame->length < 3u) {
        return;
    }
    uint16_t const code = (uint16_t)(frame->data[0] | frame->data[1] << 8);
    if (code == 0u) { /* error reset */
        return;
    }
    const struct gn_emergency_words *words = gn_emergency_of(code);
    struct gn_trouble trouble = {.code = words->fault, .remedy = words->remedy};
    trouble.index = words->fault == gonio_FaultCode_FAULT_FOLLOWING_ERROR ? 0x6065 : 0x603F;
    (void)snprintf(trouble.cause, sizeof trouble.cause, "EMCY 0x%04X %s (0x%04X)", code, words->words, trouble.index);
    gn_fault_raise(motion, i, 1u << i, &trouble);
}
