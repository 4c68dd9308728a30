/* transmit_queue.c: a short list in order; a setpoint goes to its end and the older one of its drive leaves. */
#include "transmit_queue.h"

#include <stddef.h>
#include <string.h>

static bool is_setpoint(const struct gn_can_frame *frame) {
    return frame->id > 0x200u && frame->id <= 0x27Fu; /* RPDO1 of nodes 1 to 127 */
}

static void remove_at(struct gn_transmit_queue *queue, uint32_t i) {
    queue->count--;
    memmove(&queue->frames[i], &queue->frames[i + 1u], (queue->count - i) * sizeof queue->frames[0]);
}

/* Not in place: the newer setpoint was made after the SYNC behind which it was sent, and must not take effect at it. */
static void drop_older(struct gn_transmit_queue *queue, uint32_t id) {
    for (uint32_t i = 0; i < queue->count; i++) {
        if (queue->frames[i].id == id) {
            remove_at(queue, i);
            queue->setpoints_dropped++;
            return;
        }
    }
}

bool gn_transmit_queue_push(struct gn_transmit_queue *queue, const struct gn_can_frame *frame) {
    if (is_setpoint(frame)) {
        drop_older(queue, frame->id);
    }
    if (queue->count == GN_TRANSMIT_CAPACITY) {
        return false;
    }
    queue->frames[queue->count++] = *frame;
    return true;
}

const struct gn_can_frame *gn_transmit_queue_front(const struct gn_transmit_queue *queue) {
    return queue->count > 0u ? &queue->frames[0] : NULL;
}

void gn_transmit_queue_pop(struct gn_transmit_queue *queue) {
    if (queue->count > 0u) {
        remove_at(queue, 0);
    }
}

void gn_transmit_queue_clear(struct gn_transmit_queue *queue) {
    queue->count = 0;
}
