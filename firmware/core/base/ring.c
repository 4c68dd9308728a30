/* ring.c: single-producer single-consumer ring. */
#include "ring.h"

#include <string.h>

void gn_ring_init(struct gn_ring *ring, void *slots, uint32_t record_size, uint32_t capacity) {
    *ring = (struct gn_ring){.slots = slots, .record_size = record_size, .capacity = capacity};
}

bool gn_ring_push(struct gn_ring *ring, const void *record) {
    uint32_t const read = __atomic_load_n(&ring->read, __ATOMIC_ACQUIRE);
    uint32_t const write = ring->write;
    if (write - read == ring->capacity) {
        __atomic_store_n(&ring->dropped, ring->dropped + 1u, __ATOMIC_RELAXED);
        return false;
    }
    uint32_t const slot = write & (ring->capacity - 1u);
    memcpy(ring->slots + (uint64_t)slot * ring->record_size, record, ring->record_size);
    __atomic_store_n(&ring->write, write + 1u, __ATOMIC_RELEASE);
    return true;
}

bool gn_ring_pop(struct gn_ring *ring, void *record) {
    uint32_t const write = __atomic_load_n(&ring->write, __ATOMIC_ACQUIRE);
    uint32_t const read = ring->read;
    if (write == read) {
        return false;
    }
    uint32_t const slot = read & (ring->capacity - 1u);
    memcpy(record, ring->slots + (uint64_t)slot * ring->record_size, ring->record_size);
    __atomic_store_n(&ring->read, read + 1u, __ATOMIC_RELEASE);
    return true;
}

uint32_t gn_ring_fill(const struct gn_ring *ring) {
    return __atomic_load_n(&ring->write, __ATOMIC_ACQUIRE) - __atomic_load_n(&ring->read, __ATOMIC_ACQUIRE);
}
