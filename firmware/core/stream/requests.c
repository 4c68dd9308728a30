/* requests.c: decodes requests, holds visitors to their rights, and keeps account of who waits for which reply. */
#include "requests.h"

#include <stdio.h>

#include "events.h"
#include "knots.h"
#include "pb_decode.h"

#define SAMPLE_PERIOD_MAX_US 1000000u
#define SAMPLES_PER_STROBE_MAX 10000u
#define EDGE_TOLERANCE_MAX_PERCENT 45u /* at half a period an edge could belong to either neighbour */
#define CLOCK_SETTLE_MAX_MS 9000u      /* shorter than the clock's window */

static void answer(struct gn_stream *stream, const struct gn_inbound *from, uint32_t id, gonio_ReplyCode code,
                   const char *text) {
    gonio_Reply reply = gonio_Reply_init_zero;
    reply.id = id;
    reply.code = code;
    (void)snprintf(reply.text, sizeof reply.text, "%s", text);
    gn_session_reply(&stream->session, from->client, &reply);
}

static void forward(struct gn_stream *stream, const struct gn_inbound *from, const gonio_Request *request) {
    struct gn_command const command = {.request = *request};
    if (!gn_ring_push(&stream->shared->commands, &command)) {
        answer(stream, from, request->id, gonio_ReplyCode_REPLY_REFUSED,
               "too many requests wait already; send the next after a reply");
    }
}

static void get_info_for_visitor(struct gn_stream *stream, const struct gn_inbound *from, gonio_Request *request) {
    struct gn_visitor_request *waiting = &stream->visitors[from->client];
    struct gn_command command = {.request = *request};
    command.request.id = GN_VISITOR_REQUEST_ID + from->client;
    if (waiting->open || !gn_ring_push(&stream->shared->commands, &command)) {
        answer(stream, from, request->id, gonio_ReplyCode_REPLY_REFUSED,
               "a GetInfo waits already; ask again after its reply");
        return;
    }
    *waiting = (struct gn_visitor_request){.open = true, .id = request->id};
}

static const char *fault_in(const gonio_Configure *configuration) {
    if (configuration->sample_period_us == 0u || configuration->sample_period_us > SAMPLE_PERIOD_MAX_US) {
        return "Configure.sample_period_us must be 1 to 1000000";
    }
    if (configuration->samples_per_strobe == 0u || configuration->samples_per_strobe > SAMPLES_PER_STROBE_MAX) {
        return "Configure.samples_per_strobe must be 1 to 10000";
    }
    if (configuration->edge_tolerance_percent == 0u ||
        configuration->edge_tolerance_percent > EDGE_TOLERANCE_MAX_PERCENT) {
        return "Configure.edge_tolerance_percent must be 1 to 45";
    }
    if (configuration->clock_settle_ms > CLOCK_SETTLE_MAX_MS) {
        return "Configure.clock_settle_ms must be at most 9000";
    }
    return NULL;
}

static void configure(struct gn_stream *stream, const struct gn_inbound *from, const gonio_Request *request) {
    const char *fault = fault_in(&request->body.configure);
    if (fault != NULL) {
        answer(stream, from, request->id, gonio_ReplyCode_REPLY_INVALID, fault);
        return;
    }
    if (stream->acquisition.on) {
        answer(stream, from, request->id, gonio_ReplyCode_REPLY_REFUSED,
               "acquisition is on; send Acquire off before Configure");
        return;
    }
    stream->asked =
        (struct gn_configure_request){.open = true, .id = request->id, .configuration = request->body.configure};
    forward(stream, from, request);
}

/* Acquire on while it is on begins again at sample 0: a driver that asks wants to know where it stands. */
static void acquire(struct gn_stream *stream, const struct gn_inbound *from, const gonio_Request *request,
                    int64_t now_ns) {
    if (!request->body.acquire.on) {
        gn_acquisition_stop(&stream->acquisition, now_ns);
        gn_event_counters(stream, now_ns);
        answer(stream, from, request->id, gonio_ReplyCode_REPLY_OK, "");
        return;
    }
    if (!stream->configured) {
        answer(stream, from, request->id, gonio_ReplyCode_REPLY_REFUSED,
               "no sample period is known; send Configure before Acquire");
        return;
    }
    gn_acquisition_stop(&stream->acquisition, now_ns);
    if (!gn_acquisition_start(&stream->acquisition, &stream->configuration)) {
        answer(stream, from, request->id, gonio_ReplyCode_REPLY_FAULT,
               "the digitiser does not answer; check its cable and power");
        return;
    }
    answer(stream, from, request->id, gonio_ReplyCode_REPLY_OK, "");
}

static void stop(struct gn_stream *stream, const struct gn_inbound *from, const gonio_Request *request,
                 int64_t now_ns) {
    char text[128];
    gn_stream_ask_stop(stream);
    (void)snprintf(text, sizeof text, "stop asked for by the %s: %s", from->from_driver ? "driver" : "visitor",
                   request->body.stop.reason);
    gn_event_log(stream, now_ns, GN_LOG_INFO, text);
    if (!from->from_driver) {
        gn_event_stop(stream, now_ns, &request->body.stop);
    }
    answer(stream, from, request->id, gonio_ReplyCode_REPLY_OK, "");
}

static void dispatch(struct gn_stream *stream, const struct gn_inbound *from, gonio_Request *request, int64_t now_ns) {
    switch (request->which_body) {
    case gonio_Request_stop_tag:
        stop(stream, from, request, now_ns);
        break;
    case gonio_Request_configure_tag:
        configure(stream, from, request);
        break;
    case gonio_Request_acquire_tag:
        acquire(stream, from, request, now_ns);
        break;
    default:
        forward(stream, from, request);
        break;
    }
}

void gn_requests_handle(struct gn_stream *stream, const struct gn_inbound *inbound, int64_t now_ns) {
    if (inbound->kind == GN_FRAME_KNOTS) {
        gn_knots_take(stream, inbound->payload, inbound->length, now_ns);
        return;
    }
    gonio_Request request = gonio_Request_init_zero;
    pb_istream_t bytes = pb_istream_from_buffer(inbound->payload, inbound->length);
    if (!pb_decode(&bytes, gonio_Request_fields, &request) || request.which_body == 0) {
        answer(stream, inbound, request.id, gonio_ReplyCode_REPLY_INVALID,
               "the request cannot be decoded, or asks for nothing that this firmware knows");
        return;
    }
    if (request.id >= GN_VISITOR_REQUEST_ID) {
        answer(stream, inbound, request.id, gonio_ReplyCode_REPLY_INVALID, "request ids end at 0xFFFFFEFF");
        return;
    }
    if (inbound->from_driver || request.which_body == gonio_Request_stop_tag) {
        dispatch(stream, inbound, &request, now_ns);
    } else if (request.which_body == gonio_Request_get_info_tag) {
        get_info_for_visitor(stream, inbound, &request);
    } else {
        answer(stream, inbound, request.id, gonio_ReplyCode_REPLY_NOT_DRIVER,
               "a visitor may only ask for info and stop; connect as the driver");
    }
}

static void configured_by(struct gn_stream *stream, const gonio_Reply *reply) {
    stream->asked.open = false;
    if (reply->code == gonio_ReplyCode_REPLY_OK || reply->code == gonio_ReplyCode_REPLY_ACCEPTED) {
        stream->configuration = stream->asked.configuration;
        stream->configured = true;
    }
}

void gn_requests_reply(struct gn_stream *stream, gonio_Reply *reply) {
    if (reply->which_body == gonio_Reply_info_tag) {
        gonio_Info *info = &reply->body.info;
        (void)snprintf(info->firmware, sizeof info->firmware, "%s", GN_FIRMWARE_NAME);
        (void)snprintf(info->device, sizeof info->device, "%s", stream->device_name);
        (void)snprintf(info->kernel, sizeof info->kernel, "%s", stream->shared->kernel);
        info->realtime = stream->shared->realtime;
        info->driver_connected = gn_session_driver_connected(&stream->session);
    }
    if (reply->id < GN_VISITOR_REQUEST_ID) {
        if (stream->asked.open && stream->asked.id == reply->id) {
            configured_by(stream, reply);
        }
        gn_session_reply(&stream->session, GN_LINK_CLIENTS, reply);
        return;
    }
    uint32_t const client = reply->id - GN_VISITOR_REQUEST_ID;
    if (client < GN_LINK_CLIENTS && stream->visitors[client].open) {
        stream->visitors[client].open = false;
        reply->id = stream->visitors[client].id;
        if (stream->session.clients[client].state == GN_CLIENT_VISITOR) {
            gn_session_reply(&stream->session, client, reply);
        }
    }
}
