/* selftest_codec.c: records, checksums, frames and messages on this processor, against bytes made elsewhere. */
#include <stdio.h>
#include <string.h>

#include "crc32c.h"
#include "frame.h"
#include "gonio.pb.h"
#include "pb_decode.h"
#include "pb_encode.h"
#include "selftest.h"
#include "selftest_vectors.h"

#define MESSAGE_SIZE_MAX 512u

static bool differs(char *what, size_t size, const char *name, const uint8_t *expected, const uint8_t *found,
                    size_t length) {
    for (size_t i = 0; i < length; ++i) {
        if (expected[i] != found[i]) {
            (void)snprintf(what, size, "%s: byte %zu is 0x%02x and must be 0x%02x", name, i, found[i], expected[i]);
            return true;
        }
    }
    return false;
}

bool gn_selftest_records(char *what, size_t size) {
    struct gn_pose_block const block = {.block = 3, .count = 2, .axis_count = 4, .sync_stamp_sigma_us = 12.5f};
    struct gn_pose const pose = {.sync_time_ns = INT64_C(123456789002000000),
                                 .sync_number = UINT32_MAX,
                                 .position_counts = {400000, -400000, INT32_MAX, INT32_MIN},
                                 .valid = 15};
    struct gn_knot const knot = {.time_ns = 1, .acceleration_counts_per_s2 = {0.0, 0.0, 0.0, 0.001}};
    static const uint8_t thousandth[8] = {0xfc, 0xa9, 0xf1, 0xd2, 0x4d, 0x62, 0x50, 0x3f}; /* 0.001, IEEE 754 */
    const uint8_t *bytes = gn_vector_poses_block + GN_FRAME_HEADER_SIZE;
    uint8_t found[GN_POSE_BLOCK_SIZE + GN_POSE_SIZE];
    memcpy(found, &block, GN_POSE_BLOCK_SIZE);
    memcpy(found + GN_POSE_BLOCK_SIZE, &pose, GN_POSE_SIZE);
    return !differs(what, size, "poses", bytes, found, sizeof found) &&
           !differs(what, size, "knot", thousandth, (const uint8_t *)&knot + GN_KNOT_SIZE - 8u, 8);
}

bool gn_selftest_crc32c(char *what, size_t size) {
    uint8_t bytes[32];
    static const struct {
        const char *name;
        uint8_t first, step;
        uint32_t crc;
    } known[] = {/* RFC 3720, B.4 */
                 {"32 bytes of zeros", 0x00, 0, 0x8a9136aau},
                 {"32 bytes of ones", 0xff, 0, 0x62a8ab43u},
                 {"32 bytes counting up", 0x00, 1, 0x46dd794eu},
                 {"32 bytes counting down", 0x1f, 0xff, 0x113fdb5cu}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        for (size_t k = 0; k < sizeof bytes; ++k) {
            bytes[k] = (uint8_t)(known[i].first + k * known[i].step);
        }
        uint32_t const fast = gn_crc32c(0, bytes, sizeof bytes);
        uint32_t const tables = gn_crc32c_portable(0, bytes, sizeof bytes);
        if (fast != known[i].crc || tables != known[i].crc) {
            (void)snprintf(what, size, "%s: 0x%08x by the processor, 0x%08x by tables, must be 0x%08x", known[i].name,
                           (unsigned)fast, (unsigned)tables, (unsigned)known[i].crc);
            return false;
        }
    }
    return true;
}

/* Decoded in pieces of `chunk` bytes, and made again from header fields and payload. */
static bool frame_holds(char *what, size_t size, const char *name, const uint8_t *bytes, size_t length, size_t chunk) {
    static struct gn_frame_decoder decoder;
    gn_frame_decoder_reset(&decoder);
    enum gn_frame_progress progress = GN_FRAME_INCOMPLETE;
    for (size_t at = 0; at < length;) {
        size_t taken = 0;
        progress = gn_frame_decode(&decoder, bytes + at, length - at < chunk ? length - at : chunk, &taken);
        if (taken == 0u) {
            break;
        }
        at += taken;
    }
    if (progress != GN_FRAME_COMPLETE || decoder.filled != length) {
        (void)snprintf(what, size, "%s: not taken (%s)", name, gn_frame_error_text(decoder.error));
        return false;
    }
    struct gn_frame_header const header = gn_frame_header_at(decoder.bytes);
    memset(decoder.bytes, 0, GN_FRAME_HEADER_SIZE);
    gn_frame_begin(decoder.bytes, header.kind, header.sequence, header.length);
    gn_frame_seal(decoder.bytes, header.acknowledged);
    return !differs(what, size, name, bytes, decoder.bytes, length);
}

bool gn_selftest_frames(char *what, size_t size) {
    for (size_t chunk = 1; chunk <= sizeof gn_vector_poses_block; chunk += 33) {
        if (!frame_holds(what, size, "HELLO", gn_vector_hello_driver, sizeof gn_vector_hello_driver, chunk) ||
            !frame_holds(what, size, "EVENT", gn_vector_event_status, sizeof gn_vector_event_status, chunk) ||
            !frame_holds(what, size, "POSES", gn_vector_poses_block, sizeof gn_vector_poses_block, chunk)) {
            return false;
        }
    }
    uint8_t spoilt[sizeof gn_vector_hello_driver];
    memcpy(spoilt, gn_vector_hello_driver, sizeof spoilt);
    spoilt[sizeof spoilt - 1u] ^= 1u;
    if (frame_holds(what, size, "HELLO", spoilt, sizeof spoilt, sizeof spoilt)) {
        (void)snprintf(what, size, "a frame with a flipped bit was taken");
        return false;
    }
    what[0] = '\0'; /* what the refusal said */
    return true;
}

/* Decodes a golden payload, looks at the fields by `holds`, and encodes it to the same bytes again. */
static bool message_holds(char *what, size_t size, const char *name, const uint8_t *frame, size_t frame_length,
                          const pb_msgdesc_t *fields, void *message, bool (*holds)(const void *message)) {
    const uint8_t *payload = frame + GN_FRAME_HEADER_SIZE;
    size_t const length = frame_length - GN_FRAME_HEADER_SIZE;
    uint8_t again[MESSAGE_SIZE_MAX];
    pb_istream_t in = pb_istream_from_buffer(payload, length);
    if (!pb_decode(&in, fields, message) || !holds(message)) {
        (void)snprintf(what, size, "%s: read wrongly (%s)", name, PB_GET_ERROR(&in));
        return false;
    }
    pb_ostream_t out = pb_ostream_from_buffer(again, sizeof again);
    if (!pb_encode(&out, fields, message) || out.bytes_written != length) {
        (void)snprintf(what, size, "%s: %zu bytes, must be %zu (%s)", name, out.bytes_written, length,
                       PB_GET_ERROR(&out));
        return false;
    }
    return !differs(what, size, name, payload, again, length);
}

static bool hello_holds(const void *message) {
    const gonio_Hello *hello = message;
    return hello->schema_hash == UINT64_C(0x0123456789abcdef) && hello->session_id == UINT64_C(0xdeadbeef) &&
           hello->role == gonio_Role_ROLE_DRIVER && hello->last_sequence == 41u &&
           strcmp(hello->software, "gonio 0.1.0") == 0;
}

static bool status_holds(const void *message) {
    const gonio_Event *event = message;
    const gonio_Status *status = &event->body.status;
    return event->which_body == gonio_Event_status_tag && event->time_ns == INT64_C(123456789012345) &&
           status->position_counts_count == 4 && status->position_counts[0] == 33333 &&
           status->position_counts[1] == -1 && status->position_counts[3] == INT32_MIN &&
           status->path_time_ns == INT64_C(2500000000) && status->feed == 0.5;
}

bool gn_selftest_messages(char *what, size_t size) {
    gonio_Hello hello = gonio_Hello_init_zero;
    gonio_Event event = gonio_Event_init_zero;
    return message_holds(what, size, "Hello", gn_vector_hello_driver, sizeof gn_vector_hello_driver, gonio_Hello_fields,
                         &hello, hello_holds) &&
           message_holds(what, size, "Status", gn_vector_event_status, sizeof gn_vector_event_status,
                         gonio_Event_fields, &event, status_holds);
}
