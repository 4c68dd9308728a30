/* port.h: every seam between the core and a machine, as one table of functions; port/sim and port/linux fill it in. */
#ifndef GONIO_PORT_H
#define GONIO_PORT_H

#include "can.h"
#include "digitiser.h"
#include "edge.h"
#include "link.h"
#include "log.h"
#include "out.h"

/* The core never asks for the time: now_ns comes in with each call, the next wake-up goes out. */
struct gn_port {
    struct gn_can_port can;             /* real-time thread */
    struct gn_edge_port edge;           /* real-time thread */
    struct gn_out_port out;             /* real-time thread */
    struct gn_digitiser_port digitiser; /* stream thread */
    struct gn_link_port link;           /* stream thread */
    struct gn_log_port log;             /* either; never blocks */
};

#endif
