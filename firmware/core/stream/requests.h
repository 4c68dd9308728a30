/* requests.h: what clients ask for: answered here (Acquire, Stop), or passed to motion with the reply's way back. */
#ifndef GONIO_REQUESTS_H
#define GONIO_REQUESTS_H

#include "stream_state.h"

/* A REQUEST or KNOTS frame. */
void gn_requests_handle(struct gn_stream *stream, const struct gn_inbound *inbound, int64_t now_ns);
/* A reply of motion on its way out: to whom, and what only the stream side knows is filled in. */
void gn_requests_reply(struct gn_stream *stream, gonio_Reply *reply);

#endif
