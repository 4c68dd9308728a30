/* frame_ring.c: byte ring of whole frames, with a send cursor between the oldest and the newest. */
#include "frame_ring.h"

#include <string.h>

#include "frame.h"

void gn_frame_ring_init(struct gn_frame_ring *ring, uint8_t *bytes, uint32_t capacity) {
    *ring = (struct gn_frame_ring){.bytes = bytes, .capacity = capacity};
    gn_frame_ring_clear(ring);
}

void gn_frame_ring_clear(struct gn_frame_ring *ring) {
    ring->tail = ring->head;
    ring->cursor = ring->head;
    ring->next_sequence = 1;
    ring->oldest_sequence = 1;
    ring->cursor_sequence = 1;
    ring->lost_after_sending = 0;
}

static uint32_t room_to_end(const struct gn_frame_ring *ring, uint64_t position) {
    return ring->capacity - (uint32_t)(position % ring->capacity);
}

static uint8_t *place(const struct gn_frame_ring *ring, uint64_t position) {
    return ring->bytes + position % ring->capacity;
}

/* A frame that did not fit before the end of the bytes lies at their start; a header of zeros (or no room for one) says
 * so. */
static uint64_t frame_at(const struct gn_frame_ring *ring, uint64_t position) {
    uint32_t const room = room_to_end(ring, position);
    if (room < GN_FRAME_HEADER_SIZE || gn_frame_header_at(place(ring, position)).magic == 0u) {
        return position + room;
    }
    return position;
}

static uint64_t behind(const struct gn_frame_ring *ring, uint64_t frame) {
    return frame + GN_FRAME_HEADER_SIZE + gn_frame_header_at(place(ring, frame)).length;
}

static void remove_oldest(struct gn_frame_ring *ring) {
    ring->tail = behind(ring, frame_at(ring, ring->tail));
    ++ring->oldest_sequence;
    if (ring->cursor_sequence < ring->oldest_sequence) {
        ring->cursor = ring->tail;
        ring->cursor_sequence = ring->oldest_sequence;
    }
}

static void lose_oldest(struct gn_frame_ring *ring) {
    if (ring->oldest_sequence < ring->cursor_sequence) {
        ring->lost_after_sending = ring->oldest_sequence;
    } else {
        ++ring->gap_frames;
    }
    remove_oldest(ring);
}

uint8_t *gn_frame_ring_reserve(struct gn_frame_ring *ring, uint32_t payload_length) {
    uint32_t const size = GN_FRAME_HEADER_SIZE + payload_length;
    uint32_t const room = room_to_end(ring, ring->head);
    uint64_t const start = room < size ? ring->head + room : ring->head;
    while (ring->oldest_sequence < ring->next_sequence && start + size - ring->tail > ring->capacity) {
        lose_oldest(ring);
    }
    if (start != ring->head) {
        if (room >= GN_FRAME_HEADER_SIZE) {
            memset(place(ring, ring->head), 0, GN_FRAME_HEADER_SIZE);
        }
        if (ring->oldest_sequence == ring->next_sequence) {
            ring->tail = start;
        }
        if (ring->cursor_sequence == ring->next_sequence) {
            ring->cursor = start;
        }
        ring->head = start;
    }
    return place(ring, start) + GN_FRAME_HEADER_SIZE;
}

void gn_frame_ring_commit(struct gn_frame_ring *ring, uint32_t kind, uint32_t payload_length) {
    gn_frame_begin(place(ring, ring->head), kind, ring->next_sequence, payload_length);
    ring->head += GN_FRAME_HEADER_SIZE + payload_length;
    ++ring->next_sequence;
}

const uint8_t *gn_frame_ring_next(struct gn_frame_ring *ring, uint32_t *size) {
    if (ring->cursor_sequence == ring->next_sequence) {
        return NULL;
    }
    ring->cursor = frame_at(ring, ring->cursor);
    *size = (uint32_t)(behind(ring, ring->cursor) - ring->cursor);
    return place(ring, ring->cursor);
}

void gn_frame_ring_advance(struct gn_frame_ring *ring) {
    ring->cursor = behind(ring, frame_at(ring, ring->cursor));
    ++ring->cursor_sequence;
}

bool gn_frame_ring_acknowledge(struct gn_frame_ring *ring, uint32_t sequence) {
    if (sequence >= ring->cursor_sequence) {
        return false;
    }
    while (ring->oldest_sequence <= sequence) {
        remove_oldest(ring);
    }
    return true;
}

bool gn_frame_ring_replay(struct gn_frame_ring *ring, uint32_t last_sequence) {
    if (last_sequence >= ring->next_sequence) {
        return false;
    }
    while (ring->oldest_sequence <= last_sequence) {
        remove_oldest(ring);
    }
    if (ring->lost_after_sending > last_sequence) {
        ring->gap_frames += ring->lost_after_sending - last_sequence;
    }
    ring->lost_after_sending = 0;
    ring->cursor = ring->tail;
    ring->cursor_sequence = ring->oldest_sequence;
    return true;
}
