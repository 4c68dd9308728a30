/* frame_ring.h: the firmware's numbered frames until they are acknowledged: transmit queue and replay store in one. */
#ifndef GONIO_FRAME_RING_H
#define GONIO_FRAME_RING_H

#include <stdbool.h>
#include <stdint.h>

/* Whole frames lie one behind the other in `bytes`. Positions only grow; modulo capacity they are places. When a new
 * frame needs room, the oldest unacknowledged frames fall out. */
struct gn_frame_ring {
    uint8_t *bytes;
    uint32_t capacity;
    uint64_t head;               /* behind the newest frame */
    uint64_t tail;               /* the oldest frame */
    uint64_t cursor;             /* the next frame to send */
    uint32_t next_sequence;      /* of the next frame put in */
    uint32_t oldest_sequence;    /* of the frame at the tail */
    uint32_t cursor_sequence;    /* of the frame at the cursor */
    uint32_t lost_after_sending; /* last frame that fell out after it was sent; missed only if a replay asks for it */
    uint64_t gap_frames;         /* frames that the host will never get, since start */
};

void gn_frame_ring_init(struct gn_frame_ring *ring, uint8_t *bytes, uint32_t capacity);
/* Forgets all frames and numbers from 1 again: a new session. */
void gn_frame_ring_clear(struct gn_frame_ring *ring);
/* Place for a payload of at most `payload_length` bytes, valid until the commit that must follow. */
uint8_t *gn_frame_ring_reserve(struct gn_frame_ring *ring, uint32_t payload_length);
/* Numbers the reserved frame; `payload_length` may be less than reserved. */
void gn_frame_ring_commit(struct gn_frame_ring *ring, uint32_t kind, uint32_t payload_length);
/* The next frame to send and its size on the wire; NULL: none. */
const uint8_t *gn_frame_ring_next(struct gn_frame_ring *ring, uint32_t *size);
void gn_frame_ring_advance(struct gn_frame_ring *ring);
/* Frames up to `sequence` have been handled. false: that frame was not sent yet. */
bool gn_frame_ring_acknowledge(struct gn_frame_ring *ring, uint32_t sequence);
/* After a reconnect: send again what follows `last_sequence`. false: there never was such a frame. */
bool gn_frame_ring_replay(struct gn_frame_ring *ring, uint32_t last_sequence);

#endif
