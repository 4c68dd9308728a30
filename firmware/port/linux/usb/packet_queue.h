/* packet_queue.h: the transfers to the digitiser as a queue of packets, without USB: in flight, complete, handed out,
 * in flight again. A packet that nobody takes keeps its slot, so a slow reader makes the digitiser wait, and its
 * overflow is counted there. */
#ifndef GONIO_PACKET_QUEUE_H
#define GONIO_PACKET_QUEUE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GN_PACKET_SLOTS 64u        /* 0.16 s at 100,000 samples/s: the stream thread is never away for so long */
#define GN_PACKET_SLOT_BYTES 4096u /* the longest packet is 4092; a multiple of every USB packet size */

enum gn_packet_slot {
    GN_PACKET_IDLE = 0,
    GN_PACKET_IN_FLIGHT = 1,
    GN_PACKET_COMPLETE = 2,
};

/* Transfers of one endpoint complete in the order of their submission, so the slots form a ring. */
struct gn_packet_queue {
    void *context;
    bool (*submit)(void *context, uint32_t slot); /* false: the device takes no more transfers */
    bool gone;                                    /* no transfer is submitted any more */
    uint32_t head;                                /* the next slot to hand out */
    uint32_t in_flight;
    enum gn_packet_slot slots[GN_PACKET_SLOTS];
    uint32_t lengths[GN_PACKET_SLOTS];
    uint8_t bytes[GN_PACKET_SLOTS][GN_PACKET_SLOT_BYTES];
};

/* Empty; nothing may be in flight. */
void gn_packet_queue_init(struct gn_packet_queue *queue, bool (*submit)(void *context, uint32_t slot), void *context);
/* All slots into flight, what waited is dropped; nothing may be in flight. false: the device is gone. */
bool gn_packet_queue_start(struct gn_packet_queue *queue);
/* A transfer came back with bytes. */
void gn_packet_queue_complete(struct gn_packet_queue *queue, uint32_t slot, uint32_t length);
/* A transfer came back without: cancelled, failed, or the device is gone. Nothing more is submitted. */
void gn_packet_queue_fail(struct gn_packet_queue *queue, uint32_t slot);
/* Bytes of the next packet, 0: none waiting, -1: none is to come any more. */
int gn_packet_queue_read(struct gn_packet_queue *queue, uint8_t *buffer, size_t capacity);

#endif
