/* nmt.h: NMT master commands, heartbeat consumer per node, and the firmware's own heartbeat (CiA 301). */
#ifndef GONIO_NMT_H
#define GONIO_NMT_H

#include <stdbool.h>
#include <stdint.h>

#include "can.h"

#define GN_FIRMWARE_NODE 127u

enum gn_nmt_command {
    GN_NMT_START = 0x01,
    GN_NMT_STOP = 0x02,
    GN_NMT_PRE_OPERATIONAL = 0x80,
    GN_NMT_RESET_NODE = 0x81,
    GN_NMT_RESET_COMMUNICATION = 0x82,
};

enum gn_nmt_state {
    GN_NMT_BOOT_UP = 0x00,
    GN_NMT_STATE_STOPPED = 0x04,
    GN_NMT_STATE_OPERATIONAL = 0x05,
    GN_NMT_STATE_PRE_OPERATIONAL = 0x7F,
};

struct gn_node {
    bool booted;       /* boot-up seen since the last expectation */
    bool monitored;    /* heartbeats are due */
    bool reset;        /* boot-up while monitored */
    uint8_t nmt_state; /* of the last heartbeat */
    int64_t heard_ns;  /* last heartbeat, or when monitoring began */
};

struct gn_heartbeat {  /* the firmware's own */
    int64_t period_ns; /* 0: off */
    int64_t due_ns;
    bool announced; /* boot-up message sent */
};

void gn_nmt_send(const struct gn_can_port *can, enum gn_nmt_command command, uint32_t node);

/* Forget the node; its next boot-up is expected. */
void gn_node_expect_boot_up(struct gn_node *node);
/* From now on its heartbeats are due. */
void gn_node_monitor(struct gn_node *node, int64_t now_ns);
/* A frame with COB 0x700 + node. */
void gn_node_on_frame(struct gn_node *node, const struct gn_can_frame *frame, int64_t now_ns);
bool gn_node_lost(const struct gn_node *node, int64_t timeout_ns, int64_t now_ns);
const char *gn_nmt_state_words(uint8_t state);

/* Send the firmware's heartbeat when it is due (first its boot-up message). */
void gn_heartbeat_process(struct gn_heartbeat *heartbeat, const struct gn_can_port *can, int64_t now_ns);

#endif
