/* shared.h: what passes between the real-time thread (motion) and the stream thread, and nothing else does. */
#ifndef GONIO_SHARED_H
#define GONIO_SHARED_H

#include "edge.h"
#include "gonio.pb.h"
#include "gonio_records.h"
#include "latency.h"
#include "ring.h"

#define GN_AXES 4u
#define GN_NEVER_NS INT64_MAX

/* stream -> motion. Requests that the stream side does not answer itself (it answers GetInfo, Acquire). */
struct gn_command {
    gonio_Request request;
};

/* stream -> motion. */
struct gn_knot_item {
    uint32_t path_id;
    uint32_t number;
    struct gn_knot knot;
};

/* motion -> stream: a reply to a request, or an event. */
struct gn_notice {
    bool is_reply;
    union {
        gonio_Reply reply;
        gonio_Event event;
    } as;
};

/* Motion's own counters, read by the stream thread for the Counters event (stores of one writer, read relaxed). */
struct gn_motion_counters {
    uint32_t syncs;
    uint32_t sync_echoes_lost;
    uint32_t tpdo_late;
    uint32_t tpdo_missing;
    uint32_t tpdo_duplicate;
    uint32_t can_overflow;
    uint32_t can_error_frames;
    uint32_t can_setpoints_dropped;
    uint32_t can_bus_offs;
    uint32_t clock_steps;
    uint32_t edges_lost;
    uint32_t cycles_missed;
};

#define GN_COMMAND_CAPACITY 16u
#define GN_KNOT_CAPACITY 512u
#define GN_NOTICE_CAPACITY 64u
#define GN_POSE_CAPACITY 1024u
#define GN_STROBE_CAPACITY 1024u

/* One instance for the whole firmware; the two sides get pointers to it. */
struct gn_shared {
    struct gn_ring commands; /* struct gn_command */
    struct gn_ring knots;    /* struct gn_knot_item */
    struct gn_ring notices;  /* struct gn_notice */
    struct gn_ring poses;    /* struct gn_pose */
    struct gn_ring strobes;  /* struct gn_edge, GN_LINE_STROBE only, both edges */
    struct gn_motion_counters counters;
    struct gn_latency motion_latency; /* written by the port's real-time thread; stays empty in virtual time */
    struct gn_latency stream_latency; /* by its stream thread */
    const char *kernel;               /* set before the threads start, for Info; "" in virtual time */
    bool realtime;
    float sync_stamp_sigma_us; /* motion -> stream, atomic: of the CAN interface, for the pose blocks */
    int64_t host_heard_ns;     /* stream -> motion, atomic: when the driver was last heard; 0: no driver connected */
    uint32_t stop_requested;   /* stream -> motion, atomic: counts up at each Stop, from anyone */
    uint32_t clock_locked;     /* stream -> motion, atomic; motion puts it into Status */
    uint32_t acquiring;        /* stream -> motion, atomic; for Status */

    struct gn_command command_slots[GN_COMMAND_CAPACITY];
    struct gn_knot_item knot_slots[GN_KNOT_CAPACITY];
    struct gn_notice notice_slots[GN_NOTICE_CAPACITY];
    struct gn_pose pose_slots[GN_POSE_CAPACITY];
    struct gn_edge strobe_slots[GN_STROBE_CAPACITY];
};

void gn_shared_init(struct gn_shared *shared);

#endif
