/* stream.h: the stream thread's entry point: USB digitiser, link to the host, sample clock, blocks. */
#ifndef GONIO_STREAM_H
#define GONIO_STREAM_H

#include "port.h"
#include "shared.h"

struct gn_stream; /* defined in stream_state.h; one static instance, no allocation */

struct gn_stream *gn_stream_init(const struct gn_port *port, struct gn_shared *shared, const char *device_name,
                                 uint64_t session_id);
/* Do all that is due; returns when to be called again at the latest (controller clock, ns). */
int64_t gn_stream_process(struct gn_stream *stream, int64_t now_ns);

#endif
