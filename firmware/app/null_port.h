/* null_port.h: seams with nothing behind them: the self-test has no devices, a bench may have no lines. */
#ifndef GONIO_NULL_PORT_H
#define GONIO_NULL_PORT_H

#include "port.h"

/* No frame comes or goes and the bus is down; inputs read high, as unused lines do; no digitiser. */
void gn_null_port(struct gn_port *port);
void gn_null_lines(struct gn_edge_port *edge, struct gn_out_port *out);

#endif
