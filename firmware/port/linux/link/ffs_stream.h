/* ffs_stream.h: the byte stream to the client on USB, as transfers in flight; without FunctionFS, which is injected. */
#ifndef GONIO_FFS_STREAM_H
#define GONIO_FFS_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GN_FFS_SLOTS 8u           /* per direction: 0.08 s of samples at 100,000/s wait here at most */
#define GN_FFS_SLOT_BYTES 16384u  /* FunctionFS allocates as much in the kernel for each transfer */
#define GN_FFS_SHORT_MULTIPLE 64u /* no transfer is a multiple of this: its last packet is short and ends it */

enum gn_ffs_direction { GN_FFS_FROM_HOST = 0, GN_FFS_TO_HOST = 1, GN_FFS_DIRECTIONS = 2 };

enum gn_ffs_slot_state { GN_FFS_IDLE = 0, GN_FFS_IN_FLIGHT = 1, GN_FFS_COMPLETE = 2 };

struct gn_ffs_slot {
    enum gn_ffs_slot_state state;
    uint32_t length;
    uint32_t taken;
    uint8_t bytes[GN_FFS_SLOT_BYTES];
};

struct gn_ffs_transfers {
    void *context;
    bool (*submit)(void *context, enum gn_ffs_direction direction, uint32_t slot, uint8_t *bytes, uint32_t length);
    /* The transfer comes back through gn_ffs_stream_complete, now or later. */
    void (*cancel)(void *context, enum gn_ffs_direction direction, uint32_t slot);
};

/* Transfers of one endpoint complete in the order of their submission, so the slots of each direction form a ring. */
struct gn_ffs_stream {
    struct gn_ffs_transfers transfers;
    bool open;     /* a client is there */
    bool parting;  /* the core has not been told yet that the client before went */
    bool dropping; /* what comes in belongs to nobody */
    uint32_t heads[GN_FFS_DIRECTIONS];
    uint32_t in_flight[GN_FFS_DIRECTIONS];
    struct gn_ffs_slot slots[GN_FFS_DIRECTIONS][GN_FFS_SLOTS];
};

void gn_ffs_stream_init(struct gn_ffs_stream *stream, const struct gn_ffs_transfers *transfers);
/* A client opens the stream, which must be idle: reads go into flight. */
void gn_ffs_stream_begin(struct gn_ffs_stream *stream);
/* The client went: transfers are called back. What it sent before is still read, unless `drop`. */
void gn_ffs_stream_end(struct gn_ffs_stream *stream, bool drop);
/* The core has done with the client: what it wrote still leaves, what comes in is dropped. */
void gn_ffs_stream_dismiss(struct gn_ffs_stream *stream);
bool gn_ffs_stream_idle(const struct gn_ffs_stream *stream); /* nothing in flight */
/* A transfer came back: bytes, or a negative error. */
void gn_ffs_stream_complete(struct gn_ffs_stream *stream, enum gn_ffs_direction direction, uint32_t slot,
                            int64_t result);
/* As in gn_link_port. */
int gn_ffs_stream_read(struct gn_ffs_stream *stream, uint8_t *buffer, size_t capacity);
int gn_ffs_stream_write(struct gn_ffs_stream *stream, const uint8_t *bytes, size_t length);

#endif
