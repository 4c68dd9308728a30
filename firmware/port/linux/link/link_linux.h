/* link_linux.h: the link's seam: client 0 is the USB gadget (FunctionFS), the others come over loopback TCP; used by
 * the stream thread alone. */
#ifndef GONIO_LINK_LINUX_H
#define GONIO_LINK_LINUX_H

#include <poll.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "link.h"

struct gn_link_settings {
    char functionfs[108]; /* mount point; empty: no USB */
    uint16_t tcp_port;    /* on 127.0.0.1; 0: any free one */
    bool tcp;
};

#define GN_LINK_POLLS 8u

struct gn_link_linux; /* one static instance */

/* NULL, and one line in `error`. */
struct gn_link_linux *gn_link_linux_open(const struct gn_link_settings *settings, char *error, size_t error_size);
void gn_link_linux_close(struct gn_link_linux *link);
void gn_link_linux_port(struct gn_link_linux *link, struct gn_link_port *port);
uint16_t gn_link_linux_tcp_port(const struct gn_link_linux *link);
/* What to poll; their count, at most GN_LINK_POLLS. */
uint32_t gn_link_linux_polls(const struct gn_link_linux *link, struct pollfd *polls);
/* Accepts, completes transfers, answers the gadget's events; never waits. Call before each stream_process. */
void gn_link_linux_process(struct gn_link_linux *link);

#endif
