/* knots.c: unpacks knots into motion's ring, with a check against the last credit. */
#include "knots.h"

#include <stdio.h>
#include <string.h>

#include "events.h"
#include "requests.h"

static void refuse(struct gn_stream *stream, int64_t now_ns, const char *text) {
    gn_event_log(stream, now_ns, GN_LOG_ERROR, text);
    gn_stream_ask_stop(stream);
}

/* false: the payload is no knot block, or its knots go beyond the credit. */
static bool allowed(struct gn_stream *stream, const struct gn_knot_block *block, uint32_t length, int64_t now_ns) {
    char text[160];
    if (length != GN_KNOT_BLOCK_SIZE + (uint64_t)block->count * GN_KNOT_SIZE) {
        (void)snprintf(text, sizeof text, "path %u: a knot block of %u knots has %u bytes; the path is stopped",
                       (unsigned)block->path_id, (unsigned)block->count, (unsigned)length);
        refuse(stream, now_ns, text);
        return false;
    }
    uint32_t const credit = block->path_id == stream->grant.path_id ? stream->grant.credit : 0u;
    uint64_t const sent = (uint64_t)block->first_knot + block->count;
    if (sent > credit) {
        (void)snprintf(text, sizeof text,
                       "path %u: knot %llu is beyond the credit of %u knots; the path is stopped, wait for Status",
                       (unsigned)block->path_id, (unsigned long long)(sent - 1u), (unsigned)credit);
        refuse(stream, now_ns, text);
        return false;
    }
    return true;
}

void gn_knots_take(struct gn_stream *stream, const uint8_t *payload, uint32_t length, int64_t now_ns) {
    if (length < GN_KNOT_BLOCK_SIZE) {
        refuse(stream, now_ns, "a KNOTS frame is too short for its header; the path is stopped");
        return;
    }
    struct gn_knot_block block;
    memcpy(&block, payload, sizeof block);
    if (!allowed(stream, &block, length, now_ns)) {
        return;
    }
    for (uint32_t i = 0; i < block.count; ++i) {
        struct gn_knot_item item = {.path_id = block.path_id, .number = block.first_knot + i};
        memcpy(&item.knot, payload + GN_KNOT_BLOCK_SIZE + (size_t)i * GN_KNOT_SIZE, sizeof item.knot);
        if (!gn_ring_push(&stream->shared->knots, &item)) {
            refuse(stream, now_ns, "knots come faster than motion takes them; the path is stopped");
            return;
        }
    }
}

void gn_knots_grant(struct gn_stream *stream, const gonio_Status *status) {
    /* Credit once granted stays: knots may be on their way when a path ends. */
    if (status->path_id != stream->grant.path_id || status->knot_credit > stream->grant.credit) {
        stream->grant = (struct gn_knot_grant){.path_id = status->path_id, .credit = status->knot_credit};
    }
}
