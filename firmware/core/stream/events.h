/* events.h: what the stream side itself tells the driver. */
#ifndef GONIO_EVENTS_H
#define GONIO_EVENTS_H

#include "stream_state.h"

/* Losses and totals of both threads. */
void gn_event_counters(struct gn_stream *stream, int64_t now_ns);
/* How late each thread woke up; nothing where the port does not measure it. */
void gn_event_latency(struct gn_stream *stream, int64_t now_ns);
void gn_event_log(struct gn_stream *stream, int64_t now_ns, enum gn_log_level level, const char *text);
/* Tell the driver that a visitor asked for a stop: it must not go on, even if nothing moved. */
void gn_event_stop(struct gn_stream *stream, int64_t now_ns, const gonio_Stop *stop);
void gn_event_digitiser_fault(struct gn_stream *stream, int64_t now_ns, const char *sentence);

#endif
