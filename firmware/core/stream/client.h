/* client.h: bytes to and from one client of the link. */
#ifndef GONIO_CLIENT_H
#define GONIO_CLIENT_H

#include "session.h"

/* Connected anew, or gone: nothing of the former client stays. */
void gn_client_reset(struct gn_client *client, enum gn_client_state state);
/* The next whole frame of the client; INCOMPLETE: no more bytes now, or no client; REFUSED: see the decoder's error. */
enum gn_frame_progress gn_client_next_frame(struct gn_session *session, uint32_t number);
/* Queues a message in a frame of its own. false: it does not fit. */
bool gn_client_send(struct gn_client *client, uint32_t kind, uint32_t sequence, const pb_msgdesc_t *fields,
                    const void *message);
/* Moves whole frames from the ring to the driver's output. */
void gn_client_gather(struct gn_client *client, struct gn_frame_ring *ring);
/* Writes what the link takes; a leaving client with nothing left is closed. */
void gn_client_write(struct gn_session *session, uint32_t number);

#endif
