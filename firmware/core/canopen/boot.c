/* boot.c: runs the boot steps of one drive, one SDO transfer at a time. */
#include "boot.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "boot_judge.h"
#include "boot_map.h"
#include "boot_steps.h"
#include "boot_units.h"
#include "unguarded.h"

enum phase {
    PHASE_ENTER = 0,
    PHASE_WAIT,  /* not for an SDO */
    PHASE_WRITE, /* SDO under way */
    PHASE_READ,
    PHASE_FIXED_MAP,
};

enum outcome { STEP_ON, STEP_WAIT, STEP_FAIL };

/* To the node's notes, each once. */
static void add_note(struct gn_axis *axis, const char *text) {
    size_t const used = strlen(axis->info.notes);
    if (strstr(axis->info.notes, text) == NULL) {
        (void)snprintf(axis->info.notes + used, sizeof axis->info.notes - used, "%s%s", used == 0u ? "" : ", ", text);
    }
}

/* "no 0x6007" and the like. */
static void note(struct gn_axis *axis, const char *what, uint16_t index, uint8_t subindex) {
    char name[16];
    char text[32];
    gn_object_name(index, subindex, name, sizeof name);
    (void)snprintf(text, sizeof text, what, name);
    add_note(axis, text);
}

static void read_next(struct gn_axis *axis, const struct gn_bus *bus, uint16_t index, uint8_t subindex,
                      enum phase phase) {
    gn_sdo_reset(&axis->sdo);
    (void)gn_sdo_read(&axis->sdo, bus->can, index, subindex, bus->now_ns);
    axis->boot.phase = phase;
}

static enum outcome enter(struct gn_axis *axis, const struct gn_bus *bus, const struct gn_boot_step *step) {
    struct gn_boot *boot = &axis->boot;
    boot->phase = PHASE_WAIT;
    switch (step->action) {
    case GN_BOOT_RESET:
        gn_node_expect_boot_up(&axis->node);
        gn_nmt_send(bus->can, GN_NMT_RESET_COMMUNICATION, axis->config.node);
        return STEP_ON;
    case GN_BOOT_WAIT_BOOT_UP:
    case GN_BOOT_WAIT_OPERATIONAL:
        boot->deadline_ns = bus->now_ns + (int64_t)bus->cycle->boot_timeout_ms * 1000000;
        return STEP_WAIT;
    case GN_BOOT_MONITOR:
        gn_node_monitor(&axis->node, bus->now_ns);
        return STEP_ON;
    case GN_BOOT_WAIT_FOR_OTHERS:
        return STEP_WAIT;
    case GN_BOOT_START:
        axis->drive.seen = false;
        gn_nmt_send(bus->can, GN_NMT_START, axis->config.node);
        return STEP_ON;
    case GN_BOOT_DEVICE_TYPE:
    case GN_BOOT_IDENTITY:
    case GN_BOOT_CHECK:
    case GN_BOOT_UNITS:
        read_next(axis, bus, step->index, step->subindex, PHASE_READ);
        return STEP_WAIT;
    case GN_BOOT_WRITE:
        break;
    }
    if (step->fallback == GN_BRAKE_ONLY && !axis->config.brake) {
        return STEP_ON;
    }
    if (step->fallback == GN_PERIOD && boot->period_read_only) {
        read_next(axis, bus, step->index, step->subindex, PHASE_READ);
        return STEP_WAIT;
    }
    gn_sdo_reset(&axis->sdo);
    (void)gn_sdo_write(&axis->sdo, bus->can, step->index, step->subindex, step->value(&axis->config, bus->cycle),
                       step->size, bus->now_ns);
    boot->phase = PHASE_WRITE;
    return STEP_WAIT;
}

static enum outcome wait(struct gn_axis *axis, const struct gn_bus *bus, const struct gn_boot_step *step,
                         struct gn_trouble *trouble) {
    bool const overdue = bus->now_ns >= axis->boot.deadline_ns;
    if (step->action == GN_BOOT_WAIT_FOR_OTHERS) {
        return axis->boot.start_allowed ? STEP_ON : STEP_WAIT;
    }
    if (step->action == GN_BOOT_WAIT_BOOT_UP) {
        if (axis->node.booted) {
            return STEP_ON;
        }
        if (overdue) {
            (void)snprintf(trouble->cause, sizeof trouble->cause, "no boot-up message within %u ms of its reset",
                           (unsigned)bus->cycle->boot_timeout_ms);
            trouble->code = gonio_FaultCode_FAULT_NODE_MISSING;
            trouble->remedy = "check its power, cable, node id, bit rate";
            return STEP_FAIL;
        }
        return STEP_WAIT;
    }
    if (axis->node.nmt_state == GN_NMT_STATE_OPERATIONAL && axis->drive.seen) {
        return STEP_ON;
    }
    if (overdue) {
        (void)snprintf(trouble->cause, sizeof trouble->cause, "%s %u ms after its start, %s",
                       gn_nmt_state_words(axis->node.nmt_state), (unsigned)bus->cycle->boot_timeout_ms,
                       axis->drive.seen ? "with TPDO1" : "without TPDO1 (0x1800)");
        trouble->code = gonio_FaultCode_FAULT_NODE_MISSING;
        trouble->remedy = "check 0x1800, 0x1A00 and the SYNC";
        return STEP_FAIL;
    }
    return STEP_WAIT;
}

/* No RPDO deadline: the axis may go only as fast as another guard can stop it. */
static void slow_down(struct gn_axis *axis, const struct gn_bus *bus) {
    double const speed_deg_per_s = gn_unguarded_speed_deg_per_s(&axis->config, bus->cycle);
    char limit[32];
    (void)snprintf(limit, sizeof limit, "at most %.3g deg/s", speed_deg_per_s);
    note(axis, "no %s", 0x1400, 5);
    add_note(axis, limit);
    axis->unguarded_counts_per_s = speed_deg_per_s * fabs(axis->config.counts_per_deg);
}

/* A transfer was aborted: the fallback decides. */
static enum outcome on_abort(struct gn_axis *axis, const struct gn_bus *bus, const struct gn_boot_step *step,
                             struct gn_trouble *trouble) {
    uint32_t const code = axis->sdo.abort_code;
    bool const no_object = code == (uint32_t)GN_ABORT_NO_OBJECT;
    bool const absent = no_object || code == (uint32_t)GN_ABORT_NO_SUBINDEX;
    bool const read_only = code == (uint32_t)GN_ABORT_READ_ONLY;
    enum gn_boot_fallback const fallback = step->fallback;
    if (absent && fallback == GN_SKIP_ABSENT) {
        return STEP_ON;
    }
    if (absent && (fallback == GN_NOTE_ABSENT || fallback == GN_PERIOD || fallback == GN_BRAKE_ONLY)) {
        note(axis, "no %s", step->index, no_object ? 0u : step->subindex);
        return STEP_ON;
    }
    if (absent && fallback == GN_DEADLINE) {
        slow_down(axis, bus);
        return STEP_ON;
    }
    if (read_only && fallback == GN_SKIP_READ_ONLY) {
        return STEP_ON;
    }
    if (read_only && fallback == GN_EQUAL_READ_ONLY) {
        read_next(axis, bus, step->index, step->subindex, PHASE_READ);
        return STEP_WAIT;
    }
    if (read_only && fallback == GN_PERIOD && step->subindex == 1u) {
        axis->boot.period_read_only = true;
        note(axis, "%s read only", step->index, 0);
        read_next(axis, bus, step->index, step->subindex, PHASE_READ);
        return STEP_WAIT;
    }
    if ((read_only || code == (uint32_t)GN_ABORT_DEVICE_STATE) && fallback == GN_FIXED_MAP) {
        note(axis, "fixed map %s", step->index, 0);
        read_next(axis, bus, step->index, 0, PHASE_FIXED_MAP);
        return STEP_WAIT;
    }
    gn_trouble_from_sdo(trouble, &axis->sdo, step->words);
    return STEP_FAIL;
}

static enum outcome on_map(struct gn_axis *axis, const struct gn_bus *bus, const struct gn_boot_step *step,
                           struct gn_trouble *trouble) {
    struct gn_boot *boot = &axis->boot;
    uint8_t const subindex = axis->sdo.subindex;
    if (!gn_fixed_map_take(boot, step->index, subindex, gn_sdo_value(&axis->sdo), trouble)) {
        return STEP_FAIL;
    }
    if (subindex < boot->map_count) {
        read_next(axis, bus, step->index, (uint8_t)(subindex + 1u), PHASE_FIXED_MAP);
        return STEP_WAIT;
    }
    if (!gn_fixed_map_check(&boot->fixed, step->index, trouble)) {
        return STEP_FAIL;
    }
    *(step->index == 0x1600u ? &axis->rpdo : &axis->tpdo) = boot->fixed;
    while (gn_boot_steps[boot->step + 1u].index == step->index) {
        boot->step++; /* the steps that would write this map */
    }
    return STEP_ON;
}

static enum outcome run(struct gn_axis *axis, const struct gn_bus *bus, const struct gn_boot_step *step,
                        struct gn_trouble *trouble) {
    if (axis->boot.phase == PHASE_ENTER) {
        enum outcome const outcome = enter(axis, bus, step);
        if (outcome != STEP_WAIT) {
            return outcome;
        }
    }
    if (axis->boot.phase == PHASE_WAIT) {
        return wait(axis, bus, step, trouble);
    }
    switch (axis->sdo.state) {
    case GN_SDO_IDLE:
    case GN_SDO_BUSY:
        return STEP_WAIT;
    case GN_SDO_ABORTED:
        return on_abort(axis, bus, step, trouble);
    case GN_SDO_TIMED_OUT:
        gn_trouble_from_sdo(trouble, &axis->sdo, step->words);
        return STEP_FAIL;
    case GN_SDO_DONE:
        break;
    }
    if (axis->boot.phase == PHASE_FIXED_MAP) {
        return on_map(axis, bus, step, trouble);
    }
    if (axis->boot.phase == PHASE_READ && step->action == GN_BOOT_UNITS) {
        return gn_boot_units(axis, step, trouble) ? STEP_ON : STEP_FAIL;
    }
    if (axis->boot.phase == PHASE_READ) {
        return gn_boot_judge(axis, bus, step, trouble) ? STEP_ON : STEP_FAIL;
    }
    read_next(axis, bus, step->index, step->subindex, PHASE_READ);
    return STEP_WAIT;
}

void gn_boot_begin(struct gn_axis *axis) {
    axis->boot = (struct gn_boot){.gear = {1, 1}, .feed = {0, 1}};
    axis->info = (gonio_NodeInfo){.node = axis->config.node};
    axis->drive = (struct gn_drive){.mode = GN_MODE_CSP};
    axis->homing = (struct gn_homing){0};
    axis->enabled = false;
    axis->failed = false;
    axis->homed = false;
    axis->measured = false;
    axis->unguarded_counts_per_s = 0.0;
    gn_own_maps(&axis->rpdo, &axis->tpdo);
    gn_sdo_reset(&axis->sdo);
}

enum gn_boot_progress gn_boot_process(struct gn_axis *axis, const struct gn_bus *bus, struct gn_trouble *trouble) {
    struct gn_boot *boot = &axis->boot;
    gn_sdo_process(&axis->sdo, bus->can, bus->now_ns);
    while (boot->step < gn_boot_step_count) {
        const struct gn_boot_step *step = &gn_boot_steps[boot->step];
        enum outcome const outcome = run(axis, bus, step, trouble);
        if (outcome == STEP_FAIL) {
            return GN_BOOT_FAILED;
        }
        if (outcome == STEP_WAIT) {
            return step->action == GN_BOOT_WAIT_FOR_OTHERS ? GN_BOOT_CONFIGURED : GN_BOOT_RUNNING;
        }
        boot->step++;
        boot->phase = PHASE_ENTER;
    }
    boot->operational = true;
    gn_sdo_reset(&axis->sdo);
    return GN_BOOT_DONE;
}
