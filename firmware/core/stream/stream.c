/* stream.c: one round of the stream thread: clients, strobes, samples, poses, what motion says, and out again. */
#include "stream.h"

#include <string.h>

#include "events.h"
#include "knots.h"
#include "requests.h"
#include "stream_state.h"

#define COUNTERS_EVERY_NS INT64_C(1000000000)
#define POLL_NS INT64_C(5000000) /* the rings between the threads wake nobody */

struct gn_stream *gn_stream_init(const struct gn_port *port, struct gn_shared *shared, const char *device_name,
                                 uint64_t session_id) {
    static struct gn_stream the_stream;
    struct gn_stream *stream = &the_stream;
    memset(stream, 0, sizeof *stream);
    stream->port = port;
    stream->shared = shared;
    stream->device_name = device_name;
    gn_session_init(&stream->session, &port->link, &port->log, session_id);
    gn_pose_blocks_start(&stream->poses);
    stream->acquisition.digitiser = &port->digitiser;
    stream->acquisition.strobes = &shared->strobes;
    stream->acquisition.session = &stream->session;
    return stream;
}

/* A new driver knows nothing of what the one before it had going; what that leaves behind is not for it. */
static void begin_session(struct gn_stream *stream, int64_t now_ns) {
    stream->sessions_seen = stream->session.begun;
    gn_acquisition_stop(&stream->acquisition, now_ns);
    gn_pose_blocks_start(&stream->poses);
    gn_frame_ring_clear(&stream->session.ring);
    stream->counters_due_ns = now_ns + COUNTERS_EVERY_NS;
}

static void hear_clients(struct gn_stream *stream, int64_t now_ns) {
    struct gn_inbound inbound;
    bool more = true;
    while (more) {
        more = gn_session_receive(&stream->session, now_ns, &inbound);
        if (stream->session.begun != stream->sessions_seen) {
            begin_session(stream, now_ns);
        }
        if (more) {
            gn_requests_handle(stream, &inbound, now_ns);
        }
    }
    for (uint32_t i = 0; i < GN_LINK_CLIENTS; ++i) {
        stream->visitors[i].open = stream->visitors[i].open && stream->session.clients[i].state == GN_CLIENT_VISITOR;
    }
    __atomic_store_n(&stream->shared->host_heard_ns, stream->session.heard_ns, __ATOMIC_RELEASE);
}

static void acquire(struct gn_stream *stream, int64_t now_ns) {
    const char *const trouble = gn_acquisition_process(&stream->acquisition, now_ns);
    if (trouble != NULL) {
        gn_event_digitiser_fault(stream, now_ns, trouble);
        gn_stream_ask_stop(stream);
    }
    bool const locked = gn_sample_clock_settled(&stream->acquisition.clock, now_ns);
    __atomic_store_n(&stream->shared->clock_locked, locked ? 1u : 0u, __ATOMIC_RELAXED);
    __atomic_store_n(&stream->shared->acquiring, stream->acquisition.on ? 1u : 0u, __ATOMIC_RELAXED);
}

static void send_poses(struct gn_stream *stream) {
    float sigma_us = 0.0F;
    __atomic_load(&stream->shared->sync_stamp_sigma_us, &sigma_us, __ATOMIC_RELAXED);
    uint32_t const length = gn_pose_blocks_seal(&stream->poses, stream->configuration.axis_count, sigma_us);
    gn_session_block(&stream->session, GN_FRAME_POSES, stream->poses.payload, length);
}

static void take_poses(struct gn_stream *stream, int64_t now_ns) {
    struct gn_pose pose;
    while (gn_ring_pop(&stream->shared->poses, &pose)) {
        if (gn_pose_blocks_take(&stream->poses, &pose, now_ns)) {
            send_poses(stream);
        }
    }
    if (stream->poses.count > 0u && now_ns - stream->poses.arrival_ns >= GN_BLOCK_AGE_NS) {
        send_poses(stream);
    }
}

static void take_notices(struct gn_stream *stream) {
    struct gn_notice notice;
    while (gn_ring_pop(&stream->shared->notices, &notice)) {
        if (notice.is_reply) {
            gn_requests_reply(stream, &notice.as.reply);
            continue;
        }
        if (notice.as.event.which_body == gonio_Event_status_tag) {
            gn_knots_grant(stream, &notice.as.event.body.status);
        }
        gn_session_event(&stream->session, &notice.as.event);
    }
}

int64_t gn_stream_process(struct gn_stream *stream, int64_t now_ns) {
    hear_clients(stream, now_ns);
    acquire(stream, now_ns);
    take_poses(stream, now_ns);
    take_notices(stream);
    if (now_ns >= stream->counters_due_ns) {
        gn_event_counters(stream, now_ns);
        gn_event_latency(stream, now_ns);
        stream->counters_due_ns = now_ns + COUNTERS_EVERY_NS;
    }
    gn_session_transmit(&stream->session);
    return now_ns + POLL_NS;
}
