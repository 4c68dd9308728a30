/* events.c: Counters, Log, a visitor's Stop and the digitiser's Fault, as events on the driver's session. */
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
    };
    gn_session_event(&stream->session, &event);
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
