/* ffs_stream.c: two rings of transfers, and the change from one client to the next without a byte in the wrong hands.
 */
#include "ffs_stream.h"

#include <string.h>

void gn_ffs_stream_init(struct gn_ffs_stream *stream, const struct gn_ffs_transfers *transfers) {
    memset(stream, 0, sizeof *stream);
    stream->transfers = *transfers;
}

static struct gn_ffs_slot *head_of(struct gn_ffs_stream *stream, enum gn_ffs_direction direction) {
    return &stream->slots[direction][stream->heads[direction]];
}

static void advance(struct gn_ffs_stream *stream, enum gn_ffs_direction direction) {
    stream->heads[direction] = (stream->heads[direction] + 1u) % GN_FFS_SLOTS;
}

static bool launch(struct gn_ffs_stream *stream, enum gn_ffs_direction direction, uint32_t number, uint32_t length) {
    struct gn_ffs_slot *slot = &stream->slots[direction][number];
    slot->state = GN_FFS_IN_FLIGHT;
    ++stream->in_flight[direction];
    if (stream->transfers.submit(stream->transfers.context, direction, number, slot->bytes, length)) {
        return true;
    }
    slot->state = GN_FFS_IDLE;
    --stream->in_flight[direction];
    gn_ffs_stream_end(stream, false);
    return false;
}

void gn_ffs_stream_begin(struct gn_ffs_stream *stream) {
    stream->open = true;
    stream->dropping = false;
    for (uint32_t direction = 0; direction < GN_FFS_DIRECTIONS; ++direction) {
        stream->heads[direction] = 0;
        for (uint32_t i = 0; i < GN_FFS_SLOTS; ++i) {
            stream->slots[direction][i].state = GN_FFS_IDLE;
        }
    }
    for (uint32_t i = 0; i < GN_FFS_SLOTS && stream->open; ++i) {
        (void)launch(stream, GN_FFS_FROM_HOST, i, GN_FFS_SLOT_BYTES);
    }
}

/* Newest first: bytes that come meanwhile then find the oldest, and no hole arises between them. */
static void call_back(struct gn_ffs_stream *stream, enum gn_ffs_direction direction) {
    for (uint32_t i = GN_FFS_SLOTS; i-- > 0u;) {
        uint32_t const number = (stream->heads[direction] + i) % GN_FFS_SLOTS;
        if (stream->slots[direction][number].state == GN_FFS_IN_FLIGHT) {
            stream->transfers.cancel(stream->transfers.context, direction, number);
        }
    }
}

static void drop_received(struct gn_ffs_stream *stream) {
    stream->dropping = true;
    for (uint32_t i = 0; i < GN_FFS_SLOTS; ++i) {
        struct gn_ffs_slot *slot = &stream->slots[GN_FFS_FROM_HOST][i];
        slot->state = slot->state == GN_FFS_COMPLETE ? GN_FFS_IDLE : slot->state;
    }
}

void gn_ffs_stream_end(struct gn_ffs_stream *stream, bool drop) {
    stream->parting = stream->parting || stream->open;
    stream->open = false;
    if (drop) {
        drop_received(stream);
    }
    call_back(stream, GN_FFS_FROM_HOST);
    call_back(stream, GN_FFS_TO_HOST);
}

void gn_ffs_stream_dismiss(struct gn_ffs_stream *stream) {
    stream->open = false;
    stream->parting = false;
    drop_received(stream);
    call_back(stream, GN_FFS_FROM_HOST);
}

bool gn_ffs_stream_idle(const struct gn_ffs_stream *stream) {
    return stream->in_flight[GN_FFS_FROM_HOST] == 0u && stream->in_flight[GN_FFS_TO_HOST] == 0u;
}

void gn_ffs_stream_complete(struct gn_ffs_stream *stream, enum gn_ffs_direction direction, uint32_t number,
                            int64_t result) {
    struct gn_ffs_slot *slot = &stream->slots[direction][number];
    --stream->in_flight[direction];
    slot->state = GN_FFS_IDLE;
    if (direction == GN_FFS_FROM_HOST && result >= 0 && !stream->dropping) {
        /* An empty transfer is a complete one too: its slot goes back into flight in its turn. */
        slot->state = GN_FFS_COMPLETE;
        slot->length = (uint32_t)result;
        slot->taken = 0;
    }
    if (result < 0 && stream->open) {
        gn_ffs_stream_end(stream, false); /* the endpoint is off: an event will say why */
    }
}

/* What the head holds; an emptied slot goes back into flight. */
static uint32_t take(struct gn_ffs_stream *stream, uint8_t *buffer, size_t capacity) {
    struct gn_ffs_slot *slot = head_of(stream, GN_FFS_FROM_HOST);
    uint32_t const left = slot->length - slot->taken;
    uint32_t const length = left < capacity ? left : (uint32_t)capacity;
    memcpy(buffer, slot->bytes + slot->taken, length);
    slot->taken += length;
    if (slot->taken == slot->length) {
        uint32_t const number = stream->heads[GN_FFS_FROM_HOST];
        slot->state = GN_FFS_IDLE;
        advance(stream, GN_FFS_FROM_HOST);
        if (stream->open) {
            (void)launch(stream, GN_FFS_FROM_HOST, number, GN_FFS_SLOT_BYTES);
        }
    }
    return length;
}

int gn_ffs_stream_read(struct gn_ffs_stream *stream, uint8_t *buffer, size_t capacity) {
    if (stream->open && stream->parting) {
        stream->parting = false;
        return -1;
    }
    for (uint32_t i = 0; i < GN_FFS_SLOTS && head_of(stream, GN_FFS_FROM_HOST)->state == GN_FFS_COMPLETE; ++i) {
        uint32_t const length = take(stream, buffer, capacity);
        if (length > 0u) {
            return (int)length;
        }
    }
    if (stream->open || (stream->parting && stream->in_flight[GN_FFS_FROM_HOST] > 0u)) {
        return 0;
    }
    stream->parting = false;
    return -1;
}

static uint32_t chunk_of(size_t length) {
    uint32_t const chunk = length < GN_FFS_SLOT_BYTES ? (uint32_t)length : GN_FFS_SLOT_BYTES;
    return chunk % GN_FFS_SHORT_MULTIPLE == 0u ? chunk - 1u : chunk;
}

int gn_ffs_stream_write(struct gn_ffs_stream *stream, const uint8_t *bytes, size_t length) {
    if (stream->parting && !stream->open) {
        return (int)length; /* nobody will read it, and the core has not read all of the client's last words */
    }
    if (stream->parting || !stream->open) {
        stream->parting = false;
        return -1;
    }
    size_t written = 0;
    while (written < length && stream->open && head_of(stream, GN_FFS_TO_HOST)->state == GN_FFS_IDLE) {
        uint32_t const chunk = chunk_of(length - written);
        uint32_t const number = stream->heads[GN_FFS_TO_HOST];
        memcpy(head_of(stream, GN_FFS_TO_HOST)->bytes, bytes + written, chunk);
        if (launch(stream, GN_FFS_TO_HOST, number, chunk)) {
            advance(stream, GN_FFS_TO_HOST);
            written += chunk;
        }
    }
    return (int)written;
}
