/* client.c: buffers between the link's byte streams and frames. */
#include "client.h"

#include <string.h>

#include "pb_encode.h"

void gn_client_reset(struct gn_client *client, enum gn_client_state state) {
    client->state = state;
    client->host_numbered = false;
    client->host_sequence = 0;
    client->own_sequence = 0;
    client->in_length = 0;
    client->in_taken = 0;
    client->out_length = 0;
    client->out_sent = 0;
    gn_frame_decoder_reset(&client->decoder);
}

/* false: no bytes. A client that appears gets a fresh start, one that went leaves nothing behind. */
static bool read_more(struct gn_session *session, uint32_t number) {
    struct gn_client *client = &session->clients[number];
    if (session->reads_left == 0u || client->state == GN_CLIENT_LEAVING) {
        return false;
    }
    --session->reads_left;
    int const length = session->link->read(session->link->context, number, client->in, sizeof client->in);
    if (length < 0) {
        gn_client_reset(client, GN_CLIENT_ABSENT);
        return false;
    }
    if (client->state == GN_CLIENT_ABSENT) {
        gn_client_reset(client, GN_CLIENT_GREETING);
    }
    client->in_length = (uint32_t)length;
    client->in_taken = 0;
    return length > 0;
}

enum gn_frame_progress gn_client_next_frame(struct gn_session *session, uint32_t number) {
    struct gn_client *client = &session->clients[number];
    for (;;) {
        size_t taken = 0;
        enum gn_frame_progress const progress = gn_frame_decode(&client->decoder, client->in + client->in_taken,
                                                                client->in_length - client->in_taken, &taken);
        client->in_taken += (uint32_t)taken;
        if (progress != GN_FRAME_INCOMPLETE || !read_more(session, number)) {
            return progress;
        }
    }
}

bool gn_client_send(struct gn_client *client, uint32_t kind, uint32_t sequence, const pb_msgdesc_t *fields,
                    const void *message) {
    uint32_t const room = GN_SESSION_OUT_BYTES - client->out_length;
    if (room < GN_FRAME_HEADER_SIZE) {
        return false;
    }
    uint8_t *frame = client->out + client->out_length;
    pb_ostream_t stream = pb_ostream_from_buffer(frame + GN_FRAME_HEADER_SIZE, room - GN_FRAME_HEADER_SIZE);
    if (!pb_encode(&stream, fields, message)) {
        return false;
    }
    gn_frame_begin(frame, kind, sequence, (uint32_t)stream.bytes_written);
    gn_frame_seal(frame, client->host_sequence);
    client->out_length += GN_FRAME_HEADER_SIZE + (uint32_t)stream.bytes_written;
    return true;
}

void gn_client_gather(struct gn_client *client, struct gn_frame_ring *ring) {
    uint32_t size = 0;
    const uint8_t *frame = gn_frame_ring_next(ring, &size);
    while (frame != NULL && size <= GN_SESSION_OUT_BYTES - client->out_length) {
        memcpy(client->out + client->out_length, frame, size);
        gn_frame_seal(client->out + client->out_length, client->host_sequence);
        client->out_length += size;
        gn_frame_ring_advance(ring);
        frame = gn_frame_ring_next(ring, &size);
    }
}

void gn_client_write(struct gn_session *session, uint32_t number) {
    struct gn_client *client = &session->clients[number];
    const struct gn_link_port *link = session->link;
    if (client->out_sent < client->out_length) {
        int const taken =
            link->write(link->context, number, client->out + client->out_sent, client->out_length - client->out_sent);
        if (taken < 0) {
            gn_client_reset(client, GN_CLIENT_ABSENT);
            return;
        }
        client->out_sent += (uint32_t)taken;
    }
    if (client->out_sent == client->out_length) {
        client->out_sent = 0;
        client->out_length = 0;
        if (client->state == GN_CLIENT_LEAVING) {
            link->close(link->context, number);
            gn_client_reset(client, GN_CLIENT_ABSENT);
        }
    }
}
