/* inputs.c: passes strobe edges on, reports the other lines, and faults when one drops that must not. */
#include "inputs.h"

#include <stddef.h>
#include <stdio.h>

#include "fault.h"
#include "notice.h"

#define MAKE_SAFE "make it safe, then clear the fault and home"

static const struct {
    gonio_FaultCode code;
    bool torque_off;   /* the line takes the drives' torque away */
    bool while_riding; /* a fault only while a path moves the axes: homing is meant to reach the switches */
    const char *cause;
    const char *remedy;
    const char *obstacle;
} lines[GN_LINE_COUNT] = {
    [GN_LINE_DOOR] = {gonio_FaultCode_FAULT_DOOR, false, false, "the door was opened while drives were enabled",
                      MAKE_SAFE, "the door is open: close it"},
    [GN_LINE_EMERGENCY_STOP] = {gonio_FaultCode_FAULT_EMERGENCY_STOP, true, false, "the emergency stop was pressed",
                                MAKE_SAFE, "the emergency stop is pressed: release it"},
    [GN_LINE_STO] = {gonio_FaultCode_FAULT_STO, true, false, "STO took the drives' torque away", MAKE_SAFE,
                     "STO is active: close the safety circuit"},
    [GN_LINE_LIMIT] = {gonio_FaultCode_FAULT_LIMIT, false, true, "a limit switch was reached",
                       "check min_deg, max_deg and the sign of counts_per_deg, then clear the fault and home",
                       "a limit switch is reached: home to leave it"},
};

static uint32_t bit_of(uint32_t line) {
    return 1u << (line - 1u);
}

void gn_inputs_init(struct gn_motion *motion) {
    for (uint32_t line = GN_LINE_DOOR; line < GN_LINE_COUNT; line++) {
        if (motion->port->edge.level(motion->port->edge.context, line)) {
            motion->inputs |= bit_of(line);
        }
    }
}

static void dropped(struct gn_motion *motion, uint32_t line) {
    uint32_t enabled = 0;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        enabled |= motion->axes[i].enabled ? 1u << i : 0u;
    }
    if (enabled == 0u || (lines[line].while_riding && motion->path.state == GN_PATH_IDLE)) {
        return;
    }
    struct gn_trouble trouble = {.code = lines[line].code, .remedy = lines[line].remedy};
    (void)snprintf(trouble.cause, sizeof trouble.cause, "%s", lines[line].cause);
    gn_fault_raise(motion, GN_NO_AXIS, lines[line].torque_off ? enabled : 0u, &trouble);
}

/* How many edges of this line were lost before this one. */
static uint32_t lost_before(struct gn_motion *motion, const struct gn_edge *edge) {
    uint32_t const lost = edge->number - motion->edges_seen[edge->line] - 1u;
    uint32_t *const counter = &motion->shared->counters.edges_lost;
    motion->edges_seen[edge->line] = edge->number;
    __atomic_store_n(counter, *counter + lost, __ATOMIC_RELAXED);
    return lost;
}

static void take(struct gn_motion *motion, const struct gn_edge *edge) {
    uint32_t const bit = bit_of(edge->line);
    bool const was_high = (motion->inputs & bit) != 0u;
    bool high = edge->rising;
    bool fell = !high;
    if (lost_before(motion, edge) > 0u) {
        /* Edges alternate: a line that was high fell in between, however it stands now. */
        high = motion->port->edge.level(motion->port->edge.context, edge->line);
        fell = was_high || !high;
    }
    gonio_Event event = {.which_body = gonio_Event_input_tag};
    event.body.input = (gonio_InputChange){.line = edge->line, .level = high};
    gn_event(motion, &event);
    motion->inputs = high ? motion->inputs | bit : motion->inputs & ~bit;
    if (fell) {
        dropped(motion, edge->line);
    }
}

void gn_inputs_process(struct gn_motion *motion) {
    struct gn_edge edge;
    while (motion->port->edge.receive(motion->port->edge.context, &edge)) {
        if (edge.line == GN_LINE_STROBE) {
            (void)gn_ring_push(&motion->shared->strobes, &edge); /* the stream side sees the jump in the numbers */
        } else if (edge.line < GN_LINE_COUNT) {
            take(motion, &edge);
        }
    }
}

static const char *obstacle_among(const struct gn_motion *motion, bool with_limits) {
    for (uint32_t line = GN_LINE_DOOR; line < GN_LINE_COUNT; line++) {
        if ((motion->inputs & bit_of(line)) == 0u && (with_limits || !lines[line].while_riding)) {
            return lines[line].obstacle;
        }
    }
    return NULL;
}

const char *gn_inputs_obstacle(const struct gn_motion *motion) {
    return obstacle_among(motion, false);
}

const char *gn_inputs_path_obstacle(const struct gn_motion *motion) {
    return obstacle_among(motion, true);
}
