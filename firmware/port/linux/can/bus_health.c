/* bus_health.c: reads the kernel's error frames; a controller that was off or down begins again as error active. */
#include "bus_health.h"

#include <linux/can/error.h>

#define WARNING (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)
#define PASSIVE (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)
#define OVERFLOW CAN_ERR_CRTL_RX_OVERFLOW
#define CONTROLLER_BYTE 1

static void on_controller(struct gn_bus_health *health, uint8_t bits) {
    if (bits & OVERFLOW) {
        health->chip_overflows++;
    }
    if (health->state == GN_CAN_BUS_OFF || health->state == GN_CAN_DOWN) {
        return; /* ends by a restart only */
    }
    if (bits & PASSIVE) {
        health->state = GN_CAN_ERROR_PASSIVE;
    } else if (bits & WARNING) {
        health->state = GN_CAN_ERROR_WARNING;
    } else if (bits & CAN_ERR_CRTL_ACTIVE) {
        health->state = GN_CAN_ERROR_ACTIVE;
    }
}

void gn_bus_health_on_error(struct gn_bus_health *health, const struct can_frame *frame, int64_t now_ns) {
    health->error_frames++;
    if ((frame->can_id & CAN_ERR_CRTL) && frame->can_dlc > CONTROLLER_BYTE) {
        on_controller(health, frame->data[CONTROLLER_BYTE]);
    }
    if ((frame->can_id & CAN_ERR_RESTARTED) && health->state == GN_CAN_BUS_OFF) {
        health->state = GN_CAN_ERROR_ACTIVE;
    }
    if ((frame->can_id & CAN_ERR_BUSOFF) && health->state != GN_CAN_DOWN) {
        health->state = GN_CAN_BUS_OFF;
        health->bus_off_ns = now_ns;
        health->bus_offs++;
    }
}

void gn_bus_health_on_data(struct gn_bus_health *health, int64_t now_ns) {
    if (health->state == GN_CAN_BUS_OFF && now_ns - health->bus_off_ns > GN_BUS_OFF_PROOF_NS) {
        health->state = GN_CAN_ERROR_ACTIVE;
    }
}

void gn_bus_health_on_interface(struct gn_bus_health *health, bool up) {
    if (!up) {
        health->state = GN_CAN_DOWN;
    } else if (health->state == GN_CAN_DOWN) {
        health->state = GN_CAN_ERROR_ACTIVE;
    }
}

bool gn_bus_health_can_send(const struct gn_bus_health *health) {
    return health->state != GN_CAN_BUS_OFF && health->state != GN_CAN_DOWN;
}
