/* transmit_queue.h: frames that wait for room in the kernel. A newer setpoint takes the place of an older one; nothing
 * else is ever dropped. */
#ifndef GONIO_TRANSMIT_QUEUE_H
#define GONIO_TRANSMIT_QUEUE_H

#include <stdbool.h>
#include <stdint.h>

#include "can.h"

/* Room for 100 ms of SYNCs at 500 Hz, the heartbeats, an NMT and an SDO request per drive. */
#define GN_TRANSMIT_CAPACITY 64u

struct gn_transmit_queue {
    struct gn_can_frame frames[GN_TRANSMIT_CAPACITY]; /* in the order in which they leave */
    uint32_t count;
    uint32_t setpoints_dropped; /* since start */
};

/* false: full, nothing taken. */
bool gn_transmit_queue_push(struct gn_transmit_queue *queue, const struct gn_can_frame *frame);
/* The next to leave; NULL: none. */
const struct gn_can_frame *gn_transmit_queue_front(const struct gn_transmit_queue *queue);
void gn_transmit_queue_pop(struct gn_transmit_queue *queue);
/* The bus was lost: what waited is out of date. */
void gn_transmit_queue_clear(struct gn_transmit_queue *queue);

#endif
