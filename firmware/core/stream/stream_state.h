/* stream_state.h: all that the stream thread owns; one static instance. */
#ifndef GONIO_STREAM_STATE_H
#define GONIO_STREAM_STATE_H

#include "acquisition.h"
#include "blocks.h"
#include "session.h"
#include "stream.h"

/* Requests of visitors go to motion under these ids, one at a time for each; the driver's stay below. */
#define GN_VISITOR_REQUEST_ID 0xFFFFFF00u

/* A Configure that motion has yet to accept. */
struct gn_configure_request {
    bool open;
    uint32_t id;
    gonio_Configure configuration;
};

/* What the host has been granted, from the last Status of its path. */
struct gn_knot_grant {
    uint32_t path_id;
    uint32_t credit;
};

struct gn_visitor_request {
    bool open;
    uint32_t id; /* the visitor's own */
};

struct gn_stream {
    const struct gn_port *port;
    struct gn_shared *shared;
    const char *device_name;
    uint32_t sessions_seen;
    bool configured;
    gonio_Configure configuration;
    struct gn_configure_request asked;
    struct gn_visitor_request visitors[GN_LINK_CLIENTS];
    struct gn_knot_grant grant;
    int64_t counters_due_ns;
    struct gn_pose_blocks poses;
    struct gn_acquisition acquisition;
    struct gn_session session;
};

/* Whatever moves shall be held; motion counts these. */
static inline void gn_stream_ask_stop(struct gn_stream *stream) {
    (void)__atomic_add_fetch(&stream->shared->stop_requested, 1u, __ATOMIC_RELEASE);
}

#endif
