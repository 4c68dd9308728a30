/* frame.h: frames of the link (protocol/link.md): sealing one, and finding them in a stream of bytes. */
#ifndef GONIO_FRAME_H
#define GONIO_FRAME_H

#include <stddef.h>
#include <stdint.h>

#include "gonio_records.h"

#define GN_FRAME_MAGIC 0x4E47u
#define GN_FRAME_VERSION 1u
#define GN_FRAME_PAYLOAD_MAX 65536u

enum gn_frame_error {
    GN_FRAME_GOOD = 0,
    GN_FRAME_BAD_MAGIC = 1,
    GN_FRAME_BAD_VERSION = 2,
    GN_FRAME_BAD_KIND = 3,
    GN_FRAME_BAD_LENGTH = 4,
    GN_FRAME_BAD_CRC = 5,
};

enum gn_frame_progress {
    GN_FRAME_INCOMPLETE = 0, /* all bytes taken */
    GN_FRAME_COMPLETE = 1,   /* the decoder holds a frame until it is fed again */
    GN_FRAME_REFUSED = 2,    /* the decoder's `error` says why; it takes nothing more until it is reset */
};

/* Header first, payload behind it, as on the wire. */
struct gn_frame_decoder {
    uint32_t filled;
    enum gn_frame_progress progress;
    enum gn_frame_error error;
    uint8_t bytes[GN_FRAME_HEADER_SIZE + GN_FRAME_PAYLOAD_MAX];
};

/* Writes the header before the payload at `frame`; the checksum waits for gn_frame_seal. */
void gn_frame_begin(uint8_t *frame, uint32_t kind, uint32_t sequence, uint32_t length);
/* Puts in what is known only when the frame leaves: the acknowledgement and the checksum. */
void gn_frame_seal(uint8_t *frame, uint32_t acknowledged);
struct gn_frame_header gn_frame_header_at(const uint8_t *frame);

void gn_frame_decoder_reset(struct gn_frame_decoder *decoder);
/* Takes bytes up to the end of one frame; `*taken` says how many. Refuses as early as the bytes show the error. */
enum gn_frame_progress gn_frame_decode(struct gn_frame_decoder *decoder, const uint8_t *bytes, size_t length,
                                       size_t *taken);
const char *gn_frame_error_text(enum gn_frame_error error);

#endif
