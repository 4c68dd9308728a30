/* bus_health.h: the state of bus and interface, from error frames, the socket's errors and looks at the interface. */
#ifndef GONIO_BUS_HEALTH_H
#define GONIO_BUS_HEALTH_H

#include <linux/can.h>
#include <stdbool.h>
#include <stdint.h>

#include "can.h"

/* Who is off the bus receives nothing. Frames that come this long after the bus-off prove that it is over, should the
 * notice of the restart have been lost; until then they may be older than the bus-off. */
#define GN_BUS_OFF_PROOF_NS INT64_C(1000000000)

struct gn_bus_health {
    enum gn_can_bus_state state;
    uint32_t error_frames;
    uint32_t bus_offs;
    uint32_t chip_overflows; /* the controller chip itself lost frames; how many it does not say: at least one each */
    int64_t bus_off_ns;
};

/* A frame with CAN_ERR_FLAG (linux/can/error.h). */
void gn_bus_health_on_error(struct gn_bus_health *health, const struct can_frame *frame, int64_t now_ns);
void gn_bus_health_on_data(struct gn_bus_health *health, int64_t now_ns);
/* The interface went down or away; it came up. */
void gn_bus_health_on_interface(struct gn_bus_health *health, bool up);
/* No: frames are not to be queued, they would leave out of date. */
bool gn_bus_health_can_send(const struct gn_bus_health *health);

#endif
