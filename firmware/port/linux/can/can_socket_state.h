/* can_socket_state.h: everything the CAN port owns; tests put another socket in the place of the kernel's. */
#ifndef GONIO_CAN_SOCKET_STATE_H
#define GONIO_CAN_SOCKET_STATE_H

#include "bus_health.h"
#include "can_socket.h"
#include "clock_map.h"
#include "transmit_queue.h"

struct gn_can_socket {
    struct gn_can_settings settings;
    const char *net_folder; /* GN_NET_FOLDER */
    int fd;                 /* -1: the interface is gone */
    int index;              /* of the interface that fd is bound to */
    struct gn_bus_health health;
    struct gn_clock_map clock;
    struct gn_transmit_queue queue;
    uint32_t lost;        /* the present socket's own count */
    uint32_t lost_before; /* of the sockets before it */
    int64_t retry_ns;     /* the kernel's queue was full; 0: it has room */
    int64_t look_ns;      /* next look at a lost interface */
};

/* Takes over an open, bound socket. */
void gn_can_socket_adopt(struct gn_can_socket *can, int fd);

#endif
