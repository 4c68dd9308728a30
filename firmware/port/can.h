/* can.h: the CAN seam. Classic frames, 11-bit identifiers, own frames come back as echoes with their receive stamp. */
#ifndef GONIO_PORT_CAN_H
#define GONIO_PORT_CAN_H

#include <stdbool.h>
#include <stdint.h>

struct gn_can_frame {
    uint32_t id; /* 11 bits */
    uint8_t length;
    uint8_t data[8];
    bool own_echo;         /* received copy of a frame that this controller sent */
    int64_t stamp_ns;      /* receive time, controller clock */
    bool stamp_by_arrival; /* the wall clock stepped meanwhile: the stamp is the time of reading */
};

enum gn_can_bus_state {
    GN_CAN_ERROR_ACTIVE = 0,
    GN_CAN_ERROR_WARNING = 1,
    GN_CAN_ERROR_PASSIVE = 2,
    GN_CAN_BUS_OFF = 3,
    GN_CAN_DOWN = 4, /* the interface is down or gone */
};

struct gn_can_status {
    enum gn_can_bus_state state;
    uint32_t receive_overflows; /* frames the port lost, since start */
    uint32_t error_frames;
    uint32_t setpoints_dropped; /* replaced by newer ones while they waited */
    uint32_t bus_offs;          /* since start */
    uint32_t clock_steps;       /* of the clock that stamps frames, since start */
    float sync_stamp_sigma_us;  /* standard uncertainty of an echo's stamp on this interface */
};

struct gn_can_port {
    void *context;
    /* 0: queued for transmission; -1: no room, nothing taken. Frames leave in bus arbitration order. */
    int (*send)(void *context, const struct gn_can_frame *frame);
    /* 1: one frame stored; 0: none waiting. */
    int (*receive)(void *context, struct gn_can_frame *frame);
    void (*status)(void *context, struct gn_can_status *status);
};

#endif
