/* packet_queue.c: a ring of slots; the head is the oldest transfer. */
#include "packet_queue.h"

#include <string.h>

void gn_packet_queue_init(struct gn_packet_queue *queue, bool (*submit)(void *context, uint32_t slot), void *context) {
    memset(queue, 0, sizeof *queue);
    queue->submit = submit;
    queue->context = context;
    queue->gone = true;
}

static void launch(struct gn_packet_queue *queue, uint32_t slot) {
    queue->slots[slot] = GN_PACKET_IDLE;
    if (queue->gone || !queue->submit(queue->context, slot)) {
        queue->gone = true;
        return;
    }
    queue->slots[slot] = GN_PACKET_IN_FLIGHT;
    ++queue->in_flight;
}

bool gn_packet_queue_start(struct gn_packet_queue *queue) {
    queue->gone = false;
    queue->head = 0;
    for (uint32_t slot = 0; slot < GN_PACKET_SLOTS; ++slot) {
        launch(queue, slot);
    }
    return !queue->gone;
}

void gn_packet_queue_complete(struct gn_packet_queue *queue, uint32_t slot, uint32_t length) {
    --queue->in_flight;
    queue->slots[slot] = GN_PACKET_COMPLETE;
    queue->lengths[slot] = length;
}

void gn_packet_queue_fail(struct gn_packet_queue *queue, uint32_t slot) {
    --queue->in_flight;
    queue->slots[slot] = GN_PACKET_IDLE;
    queue->gone = true;
}

/* The head's bytes; its slot goes back into flight and is the last of the ring. */
static uint32_t take(struct gn_packet_queue *queue, uint8_t *buffer, size_t capacity) {
    uint32_t const slot = queue->head;
    uint32_t const length = queue->lengths[slot] < capacity ? queue->lengths[slot] : (uint32_t)capacity;
    memcpy(buffer, queue->bytes[slot], length);
    queue->head = (slot + 1u) % GN_PACKET_SLOTS;
    launch(queue, slot);
    return length;
}

int gn_packet_queue_read(struct gn_packet_queue *queue, uint8_t *buffer, size_t capacity) {
    /* Empty transfers and, once the device is gone, idle slots between packets are no packets. */
    for (uint32_t passed = 0; passed < GN_PACKET_SLOTS && queue->slots[queue->head] != GN_PACKET_IN_FLIGHT; ++passed) {
        if (queue->slots[queue->head] == GN_PACKET_IDLE) {
            queue->head = (queue->head + 1u) % GN_PACKET_SLOTS;
            continue;
        }
        uint32_t const length = take(queue, buffer, capacity);
        if (length > 0u) {
            return (int)length;
        }
    }
    return queue->gone && queue->in_flight == 0u ? -1 : 0;
}
