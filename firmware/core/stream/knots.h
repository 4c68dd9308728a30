/* knots.h: KNOTS frames of the driver, held to the credit that it was granted. */
#ifndef GONIO_KNOTS_H
#define GONIO_KNOTS_H

#include "stream_state.h"

/* Passes the knots to motion; those beyond the credit are refused, and the path is stopped. */
void gn_knots_take(struct gn_stream *stream, const uint8_t *payload, uint32_t length, int64_t now_ns);
/* A Status on its way to the host: what it grants counts from now on. */
void gn_knots_grant(struct gn_stream *stream, const gonio_Status *status);

#endif
