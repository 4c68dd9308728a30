/* edge.h: the seam of the input lines. Both edges of every line come, stamped by the kernel, numbered per line. */
#ifndef GONIO_PORT_EDGE_H
#define GONIO_PORT_EDGE_H

#include <stdbool.h>
#include <stdint.h>

enum gn_line {
    GN_LINE_STROBE = 0,
    GN_LINE_DOOR = 1,           /* high: closed */
    GN_LINE_EMERGENCY_STOP = 2, /* high: released */
    GN_LINE_STO = 3,            /* high: drives may have torque */
    GN_LINE_LIMIT = 4,          /* high: no limit switch is reached; also high where no such line is wired */
    GN_LINE_COUNT = 5,
};

struct gn_edge {
    uint32_t line;
    uint32_t number; /* per line, from 1; a jump is a lost edge */
    bool rising;
    int64_t stamp_ns; /* controller clock; late by the interrupt's latency, never early */
};

struct gn_edge_port {
    void *context;
    int (*receive)(void *context, struct gn_edge *edge); /* 1: one stored; 0: none waiting */
    bool (*level)(void *context, uint32_t line);
};

#endif
