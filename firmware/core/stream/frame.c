/* frame.c: seals frames and finds them in a stream of bytes, whatever the chunks it comes in. */
#include "frame.h"

#include <string.h>

#include "crc32c.h"

#define CHECKED_HEADER 16u /* header bytes that the checksum covers */
#define IDENTITY 4u        /* magic, version and kind */

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "records are little-endian on the wire and in memory");

static uint32_t checksum(const uint8_t *frame, uint32_t length) {
    return gn_crc32c(gn_crc32c(0u, frame, CHECKED_HEADER), frame + GN_FRAME_HEADER_SIZE, length);
}

struct gn_frame_header gn_frame_header_at(const uint8_t *frame) {
    struct gn_frame_header header;
    memcpy(&header, frame, sizeof header);
    return header;
}

void gn_frame_begin(uint8_t *frame, uint32_t kind, uint32_t sequence, uint32_t length) {
    struct gn_frame_header const header = {.magic = GN_FRAME_MAGIC,
                                           .version = GN_FRAME_VERSION,
                                           .kind = (uint8_t)kind,
                                           .sequence = sequence,
                                           .length = length};
    memcpy(frame, &header, sizeof header);
}

void gn_frame_seal(uint8_t *frame, uint32_t acknowledged) {
    struct gn_frame_header header = gn_frame_header_at(frame);
    header.acknowledged = acknowledged;
    memcpy(frame, &header, sizeof header);
    header.crc32c = checksum(frame, header.length);
    memcpy(frame, &header, sizeof header);
}

void gn_frame_decoder_reset(struct gn_frame_decoder *decoder) {
    decoder->filled = 0;
    decoder->progress = GN_FRAME_INCOMPLETE;
    decoder->error = GN_FRAME_GOOD;
}

static enum gn_frame_error check_identity(const struct gn_frame_header *header) {
    if (header->magic != GN_FRAME_MAGIC) {
        return GN_FRAME_BAD_MAGIC;
    }
    if (header->version != GN_FRAME_VERSION) {
        return GN_FRAME_BAD_VERSION;
    }
    if (header->kind < GN_FRAME_HELLO || header->kind > GN_FRAME_ALIVE) {
        return GN_FRAME_BAD_KIND;
    }
    return GN_FRAME_GOOD;
}

/* Checks what the bytes so far can show; `*wanted` is the next place where there is something to check. */
static enum gn_frame_error check(const struct gn_frame_decoder *decoder, uint32_t *wanted) {
    if (decoder->filled < IDENTITY) {
        *wanted = IDENTITY;
        return GN_FRAME_GOOD;
    }
    struct gn_frame_header const header = gn_frame_header_at(decoder->bytes);
    if (decoder->filled < GN_FRAME_HEADER_SIZE) {
        *wanted = GN_FRAME_HEADER_SIZE;
        return check_identity(&header);
    }
    if (header.length > GN_FRAME_PAYLOAD_MAX) {
        return GN_FRAME_BAD_LENGTH;
    }
    *wanted = GN_FRAME_HEADER_SIZE + header.length;
    if (decoder->filled == *wanted && header.crc32c != checksum(decoder->bytes, header.length)) {
        return GN_FRAME_BAD_CRC;
    }
    return GN_FRAME_GOOD;
}

enum gn_frame_progress gn_frame_decode(struct gn_frame_decoder *decoder, const uint8_t *bytes, size_t length,
                                       size_t *taken) {
    *taken = 0;
    if (decoder->progress == GN_FRAME_COMPLETE) {
        gn_frame_decoder_reset(decoder);
    }
    while (decoder->progress == GN_FRAME_INCOMPLETE) {
        uint32_t wanted = 0;
        decoder->error = check(decoder, &wanted);
        if (decoder->error != GN_FRAME_GOOD) {
            decoder->progress = GN_FRAME_REFUSED;
        } else if (decoder->filled == wanted) {
            decoder->progress = GN_FRAME_COMPLETE;
        } else if (*taken == length) {
            break;
        } else {
            size_t const missing = wanted - decoder->filled;
            size_t const part = length - *taken < missing ? length - *taken : missing;
            memcpy(decoder->bytes + decoder->filled, bytes + *taken, part);
            decoder->filled += (uint32_t)part;
            *taken += part;
        }
    }
    return decoder->progress;
}

const char *gn_frame_error_text(enum gn_frame_error error) {
    switch (error) {
    case GN_FRAME_BAD_MAGIC:
        return "bad magic";
    case GN_FRAME_BAD_VERSION:
        return "bad version";
    case GN_FRAME_BAD_KIND:
        return "bad kind";
    case GN_FRAME_BAD_LENGTH:
        return "bad length";
    case GN_FRAME_BAD_CRC:
        return "bad CRC";
    case GN_FRAME_GOOD:
        break;
    }
    return "good";
}
