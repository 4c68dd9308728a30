/* selftest_client.c: a small blocking host; each step waits for a limited time. */
#include "selftest_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "pb_decode.h"
#include "pb_encode.h"

#define PATIENCE_S 20 /* the firmware answers within milliseconds; an emulated processor is slow */
#define PAYLOAD_MAX 512u

static bool send_message(struct gn_selftest_client *client, uint32_t kind, uint32_t sequence,
                         const pb_msgdesc_t *fields, const void *message) {
    uint8_t frame[GN_FRAME_HEADER_SIZE + PAYLOAD_MAX];
    pb_ostream_t stream = pb_ostream_from_buffer(frame + GN_FRAME_HEADER_SIZE, PAYLOAD_MAX);
    if (!pb_encode(&stream, fields, message)) {
        return false;
    }
    gn_frame_begin(frame, kind, sequence, (uint32_t)stream.bytes_written);
    gn_frame_seal(frame, client->acknowledged);
    size_t const length = GN_FRAME_HEADER_SIZE + stream.bytes_written;
    return send(client->socket, frame, length, MSG_NOSIGNAL) == (ssize_t)length;
}

/* The next whole frame, in the decoder. */
static bool next_frame(struct gn_selftest_client *client) {
    for (;;) {
        size_t taken = 0;
        enum gn_frame_progress const progress =
            gn_frame_decode(&client->decoder, client->in + client->taken, client->filled - client->taken, &taken);
        client->taken += (uint32_t)taken;
        if (progress == GN_FRAME_COMPLETE) {
            struct gn_frame_header const header = gn_frame_header_at(client->decoder.bytes);
            if (header.sequence != 0u) {
                client->acknowledged = header.sequence;
            }
            return true;
        }
        ssize_t const length =
            progress == GN_FRAME_REFUSED ? -1 : recv(client->socket, client->in, sizeof client->in, 0);
        if (length <= 0) {
            return false;
        }
        client->filled = (uint32_t)length;
        client->taken = 0;
    }
}

static bool decode(const struct gn_selftest_client *client, const pb_msgdesc_t *fields, void *message) {
    pb_istream_t stream = pb_istream_from_buffer(client->decoder.bytes + GN_FRAME_HEADER_SIZE,
                                                 client->decoder.filled - GN_FRAME_HEADER_SIZE);
    return pb_decode(&stream, fields, message);
}

bool gn_selftest_connect(struct gn_selftest_client *client, uint16_t port, gonio_Role role, gonio_Hello *answer) {
    memset(client, 0, sizeof *client);
    gn_frame_decoder_reset(&client->decoder);
    client->socket = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    struct timeval const patience = {.tv_sec = PATIENCE_S, .tv_usec = 0};
    struct sockaddr_in const address = {
        .sin_family = AF_INET, .sin_port = htons(port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    if (client->socket < 0 || setsockopt(client->socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0 ||
        connect(client->socket, (const struct sockaddr *)&address, sizeof address) != 0) {
        return false;
    }
    gonio_Hello hello = gonio_Hello_init_zero;
    hello.schema_hash = GN_SCHEMA_HASH;
    hello.role = role;
    (void)strcpy(hello.software, "self-test");
    return send_message(client, GN_FRAME_HELLO, 0u, gonio_Hello_fields, &hello) && next_frame(client) &&
           gn_frame_header_at(client->decoder.bytes).kind == GN_FRAME_HELLO &&
           decode(client, gonio_Hello_fields, answer) && answer->refusal[0] == '\0';
}

bool gn_selftest_request(struct gn_selftest_client *client, const gonio_Request *request) {
    return send_message(client, GN_FRAME_REQUEST, ++client->sequence, gonio_Request_fields, request);
}

bool gn_selftest_next(struct gn_selftest_client *client, bool *is_reply, gonio_Reply *reply, gonio_Event *event) {
    while (next_frame(client)) {
        uint32_t const kind = gn_frame_header_at(client->decoder.bytes).kind;
        if (kind == GN_FRAME_REPLY || kind == GN_FRAME_EVENT) {
            *is_reply = kind == GN_FRAME_REPLY;
            return *is_reply ? decode(client, gonio_Reply_fields, reply) : decode(client, gonio_Event_fields, event);
        }
    }
    return false;
}

bool gn_selftest_reply(struct gn_selftest_client *client, uint32_t id, gonio_Reply *reply) {
    bool is_reply = false;
    gonio_Event event;
    while (gn_selftest_next(client, &is_reply, reply, &event)) {
        if (is_reply) {
            return reply->id == id;
        }
    }
    return false;
}

void gn_selftest_disconnect(struct gn_selftest_client *client) {
    if (client->socket >= 0) {
        (void)close(client->socket);
        client->socket = -1;
    }
}
