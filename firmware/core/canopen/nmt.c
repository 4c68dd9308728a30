/* nmt.c: NMT master commands, heartbeat consumer and producer. */
#include "nmt.h"

void gn_nmt_send(const struct gn_can_port *can, enum gn_nmt_command command, uint32_t node) {
    struct gn_can_frame const frame = {.id = 0x000, .length = 2, .data = {(uint8_t)command, (uint8_t)node}};
    (void)can->send(can->context, &frame);
}

void gn_node_expect_boot_up(struct gn_node *node) {
    *node = (struct gn_node){.nmt_state = GN_NMT_BOOT_UP};
}

void gn_node_monitor(struct gn_node *node, int64_t now_ns) {
    node->monitored = true;
    node->heard_ns = now_ns;
}

void gn_node_on_frame(struct gn_node *node, const struct gn_can_frame *frame, int64_t now_ns) {
    if (frame->length != 1u) {
        return;
    }
    node->nmt_state = frame->data[0] & 0x7Fu; /* bit 7 is the toggle of node guarding */
    node->heard_ns = now_ns;
    if (node->nmt_state == GN_NMT_BOOT_UP) {
        node->booted = true;
        node->reset = node->reset || node->monitored;
    }
}

bool gn_node_lost(const struct gn_node *node, int64_t timeout_ns, int64_t now_ns) {
    return node->monitored && now_ns - node->heard_ns > timeout_ns;
}

const char *gn_nmt_state_words(uint8_t state) {
    switch (state) {
    case GN_NMT_BOOT_UP:
        return "initialising";
    case GN_NMT_STATE_STOPPED:
        return "stopped";
    case GN_NMT_STATE_OPERATIONAL:
        return "operational";
    case GN_NMT_STATE_PRE_OPERATIONAL:
        return "pre-operational";
    default:
        return "in an unknown NMT state";
    }
}

void gn_heartbeat_process(struct gn_heartbeat *heartbeat, const struct gn_can_port *can, int64_t now_ns) {
    if (heartbeat->period_ns == 0 || now_ns < heartbeat->due_ns) {
        return;
    }
    struct gn_can_frame const frame = {
        .id = 0x700u + GN_FIRMWARE_NODE,
        .length = 1,
        .data = {heartbeat->announced ? GN_NMT_STATE_OPERATIONAL : GN_NMT_BOOT_UP},
    };
    (void)can->send(can->context, &frame);
    heartbeat->announced = true;
    heartbeat->due_ns = now_ns + heartbeat->period_ns;
}
