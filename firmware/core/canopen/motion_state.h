/* motion_state.h: everything the real-time thread owns. */
#ifndef GONIO_MOTION_STATE_H
#define GONIO_MOTION_STATE_H

#include "axis.h"
#include "motion.h"
#include "path.h"
#include "sync.h"

#define GN_NO_AXIS 255u

enum gn_operation_kind {
    GN_OPERATION_NONE = 0,
    GN_OPERATION_BOOT = 1,
    GN_OPERATION_HOME = 2,
    GN_OPERATION_CLEAR_FAULT = 3,
    GN_OPERATION_RELEASE = 4,
};

/* A long request: accepted now, OperationDone later. */
struct gn_operation {
    enum gn_operation_kind kind;
    uint32_t request_id;
    uint32_t axis_mask; /* still to be homed */
    int64_t deadline_ns;
};

/* The path's fate, seen from the cycle. */
struct gn_ride {
    bool start;     /* MotionBegin.start was given */
    bool announced; /* PATH_RUNNING was sent */
    bool halted;    /* `end` says why */
    gonio_PathEnd end;
    int64_t underrun_ns; /* 0: none */
};

/* An SdoRead whose answer is due. */
struct gn_sdo_errand {
    bool pending;
    uint32_t request_id;
    uint32_t axis;
};

struct gn_motion {
    const struct gn_port *port;
    struct gn_shared *shared;
    int64_t now_ns;

    gonio_InstrumentState state;
    gonio_Configure cycle;
    bool configured;
    struct gn_axis axes[GN_AXES];
    struct gn_operation operation;
    struct gn_sdo_errand errand;

    struct gn_sync sync;
    bool sync_running;
    bool rpdo_pending; /* of the last SYNC */
    uint32_t bus_offs_seen;
    bool bus_passive; /* error passive since the bus was last well */
    struct gn_heartbeat heartbeat;
    int64_t next_cycle_ns;
    int64_t next_status_ns;

    struct gn_path path;
    struct gn_ride ride;
    int32_t standing_counts[GN_AXES]; /* measured at the last cycle */
    uint32_t still_cycles;

    uint32_t stops_seen;
    int64_t heard_ns; /* last word of the driver */
    bool shutter_open;
    bool lamp_on;
    bool dark_when_still; /* close the shutter as soon as the axes stand */
    int64_t dark_deadline_ns;
    uint32_t inputs; /* bit 0 door closed, 1 emergency stop released, 2 STO released, 3 off the limit switches */
    uint32_t edges_seen[GN_LINE_COUNT]; /* number of the last edge of each line */
    gonio_Fault last_fault;             /* since start */
};

static inline uint32_t gn_all_axes(const struct gn_motion *motion) {
    return motion->configured ? (1u << motion->cycle.axis_count) - 1u : 0u;
}

static inline struct gn_bus gn_motion_bus(const struct gn_motion *motion) {
    return (struct gn_bus){.can = &motion->port->can, .cycle = &motion->cycle, .now_ns = motion->now_ns};
}

static inline int64_t gn_cycle_period_ns(const struct gn_motion *motion) {
    return (int64_t)motion->cycle.sync_period_us * 1000;
}

#endif
