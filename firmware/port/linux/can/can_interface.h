/* can_interface.h: looks at the network interface: is it there, is it up, and in what state is its controller. */
#ifndef GONIO_CAN_INTERFACE_H
#define GONIO_CAN_INTERFACE_H

#include <stdbool.h>

#include "can.h"

struct gn_can_look {
    int index; /* 0: there is no such interface */
    bool is_can;
    bool up;
};

#define GN_NET_FOLDER "/sys/class/net"

/* Reads small files below `folder`; takes no lock that a configuration of the network holds for long, and loads no
 * module (as the ioctl for it would), so the real-time thread may do it. */
struct gn_can_look gn_can_interface_look(const char *folder, const char *name);
/* A controller's state now, by netlink; active where the interface has none (vcan). May wait: at start only. */
enum gn_can_bus_state gn_can_interface_state(int index);

#endif
