/* fuzz_link_frame.c: anything a host may send, through frames, session, requests and knots of the whole stream side. */
#include <stdlib.h>
#include <string.h>

#include "frame.h"
#include "gonio.pb.h"
#include "pb_encode.h"
#include "stream.h"

#define STREAM_BYTES 8192u
#define SEALED_PAYLOAD_MAX 512u

/* The link's other end: what the host says, cut into chunks of 1 to 64 bytes. */
struct host {
    uint8_t bytes[STREAM_BYTES];
    size_t length;
    size_t taken;
    bool connected;
    struct gn_frame_decoder decoder; /* of what the firmware says */
};

static int link_read(void *context, uint32_t client, uint8_t *buffer, size_t capacity) {
    struct host *host = context;
    if (client != 0u || !host->connected) {
        return -1;
    }
    size_t length = 1u + host->taken * 7u % 64u;
    length = length < capacity ? length : capacity;
    length = length < host->length - host->taken ? length : host->length - host->taken;
    memcpy(buffer, host->bytes + host->taken, length);
    host->taken += length;
    return (int)length;
}

/* The firmware must say nothing but good frames. */
static int link_write(void *context, uint32_t client, const uint8_t *bytes, size_t length) {
    struct host *host = context;
    if (client != 0u || !host->connected) {
        return -1;
    }
    size_t at = 0;
    while (at < length) {
        size_t taken = 0;
        if (gn_frame_decode(&host->decoder, bytes + at, length - at, &taken) == GN_FRAME_REFUSED) {
            abort();
        }
        at += taken;
    }
    return (int)length;
}

static void link_close(void *context, uint32_t client) {
    struct host *host = context;
    host->connected = host->connected && client != 0u;
}

static int digitiser_start(void *context, uint32_t sample_period_us, uint32_t samples_per_strobe) {
    (void)context;
    if (sample_period_us == 0u || samples_per_strobe == 0u) {
        abort();
    }
    return 0;
}

static void digitiser_stop(void *context) {
    (void)context;
}

static int digitiser_read(void *context, uint8_t *buffer, size_t capacity) {
    (void)context;
    (void)buffer;
    (void)capacity;
    return 0;
}

static void log_write(void *context, enum gn_log_level level, const char *text) {
    (void)context;
    (void)level;
    if (strlen(text) > 200u) {
        abort();
    }
}

/* Bytes of the fuzzer become frames with a right checksum, since it would hardly find one: kind, length, payload. */
static void say_sealed(struct host *host, const uint8_t *data, size_t size) {
    uint32_t sequence = 0;
    while (size >= 3u) {
        uint32_t const kind = data[0] % 10u;
        size_t length = (size_t)data[1] | (size_t)(data[2] & 1u) << 8u;
        data += 3;
        size -= 3u;
        length = length < size ? length : size;
        if (host->length + GN_FRAME_HEADER_SIZE + length > STREAM_BYTES) {
            return;
        }
        uint8_t *frame = host->bytes + host->length;
        memcpy(frame + GN_FRAME_HEADER_SIZE, data, length);
        bool const numbered = kind == GN_FRAME_REQUEST || kind == GN_FRAME_KNOTS;
        gn_frame_begin(frame, kind, numbered ? ++sequence : 0u, (uint32_t)length);
        gn_frame_seal(frame, 0u);
        host->length += GN_FRAME_HEADER_SIZE + length;
        data += length;
        size -= length;
    }
}

static void say_hello(struct host *host, gonio_Role role) {
    gonio_Hello hello = gonio_Hello_init_zero;
    hello.schema_hash = GN_SCHEMA_HASH;
    hello.role = role;
    pb_ostream_t stream = pb_ostream_from_buffer(host->bytes + GN_FRAME_HEADER_SIZE, SEALED_PAYLOAD_MAX);
    if (!pb_encode(&stream, gonio_Hello_fields, &hello)) {
        abort();
    }
    gn_frame_begin(host->bytes, GN_FRAME_HELLO, 0u, (uint32_t)stream.bytes_written);
    gn_frame_seal(host->bytes, 0u);
    host->length = GN_FRAME_HEADER_SIZE + stream.bytes_written;
}

/* Motion's side: accepts every request, grants knots, and checks that what arrives is what a driver may send. */
static void answer_as_motion(struct gn_shared *shared) {
    struct gn_command command;
    while (gn_ring_pop(&shared->commands, &command)) {
        struct gn_notice notice = {.is_reply = true};
        notice.as.reply.id = command.request.id;
        (void)gn_ring_push(&shared->notices, &notice);
    }
    struct gn_notice status = {.is_reply = false};
    status.as.event.which_body = gonio_Event_status_tag;
    status.as.event.body.status.path_id = 1;
    status.as.event.body.status.knot_credit = 4;
    (void)gn_ring_push(&shared->notices, &status);
    struct gn_knot_item item;
    while (gn_ring_pop(&shared->knots, &item)) {
        if (item.path_id != 1u || item.number >= 4u) {
            abort();
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct host host;
    static struct gn_shared shared;
    static struct gn_port port;
    if (size < 1u || size > STREAM_BYTES / 2u) {
        return 0;
    }
    host.length = 0;
    host.taken = 0;
    host.connected = true;
    gn_frame_decoder_reset(&host.decoder);
    gn_shared_init(&shared);
    port.link = (struct gn_link_port){&host, link_read, link_write, link_close};
    port.digitiser = (struct gn_digitiser_port){NULL, digitiser_start, digitiser_stop, digitiser_read};
    port.log = (struct gn_log_port){NULL, log_write};
    struct gn_stream *stream = gn_stream_init(&port, &shared, "fuzz", 1u);
    if ((data[0] & 1u) != 0u) {
        say_hello(&host, (data[0] & 2u) != 0u ? gonio_Role_ROLE_DRIVER : gonio_Role_ROLE_VISITOR);
    }
    if ((data[0] & 4u) != 0u) {
        say_sealed(&host, data + 1, size - 1u);
    } else {
        memcpy(host.bytes + host.length, data + 1, size - 1u);
        host.length += size - 1u;
    }
    int64_t now_ns = 0;
    while (host.connected && host.taken < host.length) {
        now_ns += 50000000;
        (void)gn_stream_process(stream, now_ns);
        answer_as_motion(&shared);
    }
    host.connected = false;
    (void)gn_stream_process(stream, now_ns + 1);
    return 0;
}
