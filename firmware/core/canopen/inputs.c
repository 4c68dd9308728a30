/* inputs.c: passes strobe edges on, reports the other lines, and faults when one drops under enabled drives. */
#include "inputs.h"

#include <stddef.h>
#include <stdio.h>

#include "fault.h"
#include "notice.h"

static const struct {
    gonio_FaultCode code;
    bool torque_off; /* the line takes the drives' torque away */
    const char *cause;
    const char *obstacle;
} lines[GN_LINE_COUNT] = {
    [GN_LINE_DOOR] = {gonio_FaultCode_FAULT_DOOR, false, "the door was opened while drives were enabled",
                      "the door is open: close it"},
    [GN_LINE_EMERGENCY_STOP] = {gonio_FaultCode_FAULT_EMERGENCY_STOP, true, "the emergency stop was pressed",
                                "the emergency stop is pressed: release it"},
    [GN_LINE_STO] = {gonio_FaultCode_FAULT_STO, true, "STO took the drives' torque away",
                     "STO is active: close the safety circuit"},
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
    if (enabled == 0u) {
        return;
    }
    struct gn_trouble trouble = {.code = lines[line].code, .remedy = "make it safe, then clear the fault and home"};
    (void)snprintf(trouble.cause, sizeof trouble.cause, "%s", lines[line].cause);
    gn_fault_raise(motion, GN_NO_AXIS, lines[line].torque_off ? enabled : 0u, &trouble);
}

void gn_inputs_process(struct gn_motion *motion) {
    struct gn_edge edge;
    while (motion->port->edge.receive(motion->port->edge.context, &edge)) {
        if (edge.line == GN_LINE_STROBE) {
            (void)gn_ring_push(&motion->shared->strobes, &edge); /* the stream side sees the jump in the numbers */
            continue;
        }
        if (edge.line >= GN_LINE_COUNT) {
            continue;
        }
        gonio_Event event = {.which_body = gonio_Event_input_tag};
        event.body.input = (gonio_InputChange){.line = edge.line, .level = edge.rising};
        gn_event(motion, &event);
        if (edge.rising) {
            motion->inputs |= bit_of(edge.line);
        } else {
            motion->inputs &= ~bit_of(edge.line);
            dropped(motion, edge.line);
        }
    }
}

const char *gn_inputs_obstacle(const struct gn_motion *motion) {
    for (uint32_t line = GN_LINE_DOOR; line < GN_LINE_COUNT; line++) {
        if ((motion->inputs & bit_of(line)) == 0u) {
            return lines[line].obstacle;
        }
    }
    return NULL;
}
