/* out.h: the seam of the outputs. Dead means safe: without watchdog pulses the board closes the shutter by itself. */
#ifndef GONIO_PORT_OUT_H
#define GONIO_PORT_OUT_H

#include <stdbool.h>
#include <stdint.h>

enum gn_out {
    GN_OUT_SHUTTER = 1, /* on: open */
    GN_OUT_LAMP = 2,    /* on: enabled */
};

struct gn_out_port {
    void *context;
    void (*set)(void *context, uint32_t output, bool on);
    void (*pulse_watchdog)(void *context); /* once per SYNC cycle while all is well */
    /* The operator says what was done by hand (gonio_OperatorAction); only the twin acts on it. */
    void (*operator_done)(void *context, uint32_t action);
};

#endif
