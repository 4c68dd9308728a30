/* ring.h: single-producer single-consumer ring of fixed records; the only thing the two threads share. */
#ifndef GONIO_RING_H
#define GONIO_RING_H

#include <stdbool.h>
#include <stdint.h>

/* `write` and `read` only grow; their difference is the fill. Capacity is a power of two. */
struct gn_ring {
    uint8_t *slots;
    uint32_t record_size;
    uint32_t capacity;
    uint32_t write;   /* owned by the producer, released with a store-release */
    uint32_t read;    /* owned by the consumer */
    uint32_t dropped; /* records refused because the ring was full; written by the producer */
};

void gn_ring_init(struct gn_ring *ring, void *slots, uint32_t record_size, uint32_t capacity);
/* false: full, nothing written, `dropped` counted. */
bool gn_ring_push(struct gn_ring *ring, const void *record);
/* false: empty. */
bool gn_ring_pop(struct gn_ring *ring, void *record);
uint32_t gn_ring_fill(const struct gn_ring *ring);

#endif
