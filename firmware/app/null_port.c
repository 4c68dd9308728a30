/* null_port.c: what the core gets to hear from seams with nothing behind them. */
#include "null_port.h"

#include <string.h>

static int can_send(void *context, const struct gn_can_frame *frame) {
    (void)context;
    (void)frame;
    return -1;
}

static int can_receive(void *context, struct gn_can_frame *frame) {
    (void)context;
    (void)frame;
    return 0;
}

static void can_status(void *context, struct gn_can_status *status) {
    (void)context;
    *status = (struct gn_can_status){.state = GN_CAN_DOWN};
}

static int edge_receive(void *context, struct gn_edge *edge) {
    (void)context;
    (void)edge;
    return 0;
}

static bool edge_level(void *context, uint32_t line) {
    (void)context;
    return line != GN_LINE_STROBE;
}

static void out_set(void *context, uint32_t output, bool on) {
    (void)context;
    (void)output;
    (void)on;
}

static void out_pulse(void *context) {
    (void)context;
}

static void operator_done(void *context, uint32_t action) {
    (void)context;
    (void)action;
}

static int digitiser_start(void *context, uint32_t sample_period_us, uint32_t samples_per_strobe) {
    (void)context;
    (void)sample_period_us;
    (void)samples_per_strobe;
    return -1;
}

static void digitiser_stop(void *context) {
    (void)context;
}

static int digitiser_read(void *context, uint8_t *buffer, size_t capacity) {
    (void)context;
    (void)buffer;
    (void)capacity;
    return -1;
}

static int link_read(void *context, uint32_t client, uint8_t *buffer, size_t capacity) {
    (void)context;
    (void)client;
    (void)buffer;
    (void)capacity;
    return -1;
}

static int link_write(void *context, uint32_t client, const uint8_t *bytes, size_t length) {
    (void)context;
    (void)client;
    (void)bytes;
    (void)length;
    return -1;
}

static void link_close(void *context, uint32_t client) {
    (void)context;
    (void)client;
}

static void log_write(void *context, enum gn_log_level level, const char *text) {
    (void)context;
    (void)level;
    (void)text;
}

void gn_null_lines(struct gn_edge_port *edge, struct gn_out_port *out) {
    *edge = (struct gn_edge_port){NULL, edge_receive, edge_level};
    *out = (struct gn_out_port){NULL, out_set, out_pulse, operator_done};
}

void gn_null_port(struct gn_port *port) {
    memset(port, 0, sizeof *port);
    port->can = (struct gn_can_port){NULL, can_send, can_receive, can_status};
    gn_null_lines(&port->edge, &port->out);
    port->digitiser = (struct gn_digitiser_port){NULL, digitiser_start, digitiser_stop, digitiser_read};
    port->link = (struct gn_link_port){NULL, link_read, link_write, link_close};
    port->log = (struct gn_log_port){NULL, log_write};
}
