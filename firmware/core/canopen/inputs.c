/* inputs.c: passes strobe edges on, reports the other lines, and faults when one drops that must not. */
#include "inputs.h"

#include <stdio.h>

#include "fault.h"
#include "input_lines.h"
#include "notice.h"

void gn_inputs_init(struct gn_motion *motion) {
    for (uint32_t line = GN_LINE_DOOR; line < GN_LINE_COUNT; line++) {
        if (motion->port->edge.level(motion->port->edge.context, line)) {
            motion->inputs |= gn_input_bit(line);
        }
    }
}

/* Emergency stop and door take the torque too, and the kernel may tell of that line first: it names the cause. */
static uint32_t cause_of(const struct gn_motion *motion, uint32_t line) {
    const uint32_t causes[] = {GN_LINE_EMERGENCY_STOP, GN_LINE_DOOR};
    for (uint32_t i = 0; line == GN_LINE_STO && i < sizeof causes / sizeof causes[0]; i++) {
        if (!motion->port->edge.level(motion->port->edge.context, causes[i])) {
            return causes[i];
        }
    }
    return line;
}

static void dropped(struct gn_motion *motion, uint32_t line) {
    uint32_t enabled = 0;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        enabled |= motion->axes[i].enabled ? 1u << i : 0u;
    }
    const struct gn_input_line *meaning = gn_input_line(cause_of(motion, line));
    if (enabled == 0u || (meaning->while_riding && motion->path.state == GN_PATH_IDLE)) {
        return;
    }
    struct gn_trouble trouble = {.code = meaning->code, .remedy = meaning->remedy};
    (void)snprintf(trouble.cause, sizeof trouble.cause, "%s", meaning->cause);
    gn_fault_raise(motion, GN_NO_AXIS, gn_input_line(line)->torque_off ? enabled : 0u, &trouble);
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
    uint32_t const bit = gn_input_bit(edge->line);
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
