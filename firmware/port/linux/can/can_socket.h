/* can_socket.h: the CAN seam on SocketCAN; used by the real-time thread alone. */
#ifndef GONIO_CAN_SOCKET_H
#define GONIO_CAN_SOCKET_H

#include <stdbool.h>
#include <stddef.h>

#include "can.h"

struct gn_can_socket; /* one static instance, no allocation */

struct gn_can_settings {
    char interface[16];
    float sync_stamp_sigma_us; /* standard uncertainty of an echo's receive stamp on this interface */
};

/* NULL, and one line in `error`: there is no such interface, it is no CAN interface, or no right to open it. An
 * interface that is there but down is opened; its status says so. */
struct gn_can_socket *gn_can_socket_open(const struct gn_can_settings *settings, char *error, size_t error_size);
void gn_can_socket_close(struct gn_can_socket *can);
void gn_can_socket_port(struct gn_can_socket *can, struct gn_can_port *port);
/* To be polled for input; changes when the interface went and came back, -1 while there is none. */
int gn_can_socket_fd(const struct gn_can_socket *can);
/* Sends what waited for room in the kernel's queue, looks after a lost interface. Call before each motion_process.
 * Returns when it wants to be called again at the latest (GN_NEVER_NS: only for input). */
int64_t gn_can_socket_process(struct gn_can_socket *can, int64_t now_ns);

#endif
