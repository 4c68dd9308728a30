/* events.c: Counters, Latency, Log, a visitor's Stop and the digitiser's Fault, as events on the driver's session. */
#include "events.h"

#include <stdio.h>

#define NO_AXIS 255u

static uint64_t count_of(const uint32_t *counter) {
    return __atomic_load_n(counter, __ATOMIC_RELAXED);
}

void gn_event_counters(struct gn_stream *stream, int64_t now_ns) {
    const struct gn_acquisition *acquisition = &stream->acquisition;
    const struct gn_motion_counters *motion = &stream->shared->counters;
    gonio_Event event = gonio_Event_init_zero;
    event.time_ns = now_ns;
    event.which_body = gonio_Event_counters_tag;
    event.body.counters = (gonio_Counters){
        .samples = acquisition->packets.samples,
        .samples_lost = acquisition->packets.samples_lost,
        .packets_lost = acquisition->packets.packets_lost,
        .strobes = acquisition->clock.strobes,
        .strobes_lost = acquisition->clock.strobes_lost,
        .strobes_rejected = acquisition->clock.strobes_rejected,
        .syncs = count_of(&motion->syncs),
        .sync_echoes_lost = count_of(&motion->sync_echoes_lost),
        .tpdo_late = count_of(&motion->tpdo_late),
        .tpdo_missing = count_of(&motion->tpdo_missing),
        .tpdo_duplicate = count_of(&motion->tpdo_duplicate),
        .can_overflow = count_of(&motion->can_overflow),
        .can_error_frames = count_of(&motion->can_error_frames),
        .link_gap_frames = stream->session.ring.gap_frames,
        .poses_dropped = count_of(&stream->shared->poses.dropped),
        .strobe_realigned = acquisition->clock.strobe_realigned,
        .cycles_missed = count_of(&motion->cycles_missed),
        .can_setpoints_dropped = count_of(&motion->can_setpoints_dropped),
        .can_bus_offs = count_of(&motion->can_bus_offs),
        .clock_steps = count_of(&motion->clock_steps),
        .edges_lost = count_of(&motion->edges_lost),
    };
    gn_session_event(&stream->session, &event);
}

static void send_latency(struct gn_stream *stream, int64_t now_ns, gonio_Thread thread,
                         const struct gn_latency *latency) {
    gonio_Event event = gonio_Event_init_zero;
    gonio_Latency *body = &event.body.latency;
    event.time_ns = now_ns;
    event.which_body = gonio_Event_latency_tag;
    body->thread = thread;
    body->wakeups = count_of(&latency->wakeups);
    body->max_us = __atomic_load_n(&latency->max_us, __ATOMIC_RELAXED);
    body->bins_count = GN_LATENCY_BINS;
    for (uint32_t i = 0; i < GN_LATENCY_BINS; i++) {
        body->bins[i] = __atomic_load_n(&latency->bins[i], __ATOMIC_RELAXED);
    }
    if (body->wakeups > 0u) {
        gn_session_event(&stream->session, &event);
    }
}

void gn_event_latency(struct gn_stream *stream, int64_t now_ns) {
    send_latency(stream, now_ns, gonio_Thread_THREAD_MOTION, &stream->shared->motion_latency);
    send_latency(stream, now_ns, gonio_Thread_THREAD_STREAM, &stream->shared->stream_latency);
}

void gn_event_log(struct gn_stream *stream, int64_t now_ns, enum gn_log_level level, const char *text) {
    gonio_Event event = gonio_Event_init_zero;
    event.time_ns = now_ns;
    event.which_body = gonio_Event_log_tag;
    event.body.log.level = (uint32_t)level;
    (void)snprintf(event.body.log.text, sizeof event.body.log.text, "%s", text);
    gn_session_event(&stream->session, &event);
    stream->port->log.write(stream->port->log.context, level, text);
}

void gn_event_stop(struct gn_stream *stream, int64_t now_ns, const gonio_Stop *stop) {
    gonio_Event event = gonio_Event_init_zero;
    event.time_ns = now_ns;
    event.which_body = gonio_Event_stop_tag;
    event.body.stop = *stop;
    gn_session_event(&stream->session, &event);
}

void gn_event_digitiser_fault(struct gn_stream *stream, int64_t now_ns, const char *sentence) {
    gonio_Event event = gonio_Event_init_zero;
    event.time_ns = now_ns;
    event.which_body = gonio_Event_fault_tag;
    event.body.fault.code = gonio_FaultCode_FAULT_DIGITISER;
    event.body.fault.axis = NO_AXIS;
    (void)snprintf(event.body.fault.sentence, sizeof event.body.fault.sentence, "%s", sentence);
    gn_session_event(&stream->session, &event);
}
