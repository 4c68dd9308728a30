/* session.c: who may talk, and in which session; frames that break the protocol end their connection. */
#include "session.h"

#include <stdio.h>
#include <string.h>

#include "client.h"
#include "pb_decode.h"
#include "pb_encode.h"

#define READS_PER_CYCLE 32u

void gn_session_init(struct gn_session *session, const struct gn_link_port *link, const struct gn_log_port *log,
                     uint64_t id) {
    session->link = link;
    session->log = log;
    session->id = id;
    session->open = false;
    session->begun = 0;
    session->heard_ns = 0;
    session->reads_left = READS_PER_CYCLE;
    gn_frame_ring_init(&session->ring, session->ring_bytes, sizeof session->ring_bytes);
    for (uint32_t i = 0; i < GN_LINK_CLIENTS; ++i) {
        gn_client_reset(&session->clients[i], GN_CLIENT_ABSENT);
    }
}

/* The decoder may hold bytes that nobody will read; what is queued still leaves first. */
static void dismiss(struct gn_session *session, uint32_t number, const char *why) {
    char line[192];
    (void)snprintf(line, sizeof line, "link: client %u dismissed: %s", (unsigned)number, why);
    session->log->write(session->log->context, GN_LOG_WARNING, line);
    session->clients[number].state = GN_CLIENT_LEAVING;
}

static uint32_t driver_of(const struct gn_session *session) {
    uint32_t number = 0;
    while (number < GN_LINK_CLIENTS && session->clients[number].state != GN_CLIENT_DRIVER) {
        ++number;
    }
    return number;
}

bool gn_session_driver_connected(const struct gn_session *session) {
    return driver_of(session) < GN_LINK_CLIENTS;
}

/* A new session for the driver, or the one that it wants to continue. false: `hello->refusal` says why not. */
static bool admit_driver(struct gn_session *session, const gonio_Hello *theirs, gonio_Hello *ours) {
    bool const continues = session->open && theirs->session_id == session->id;
    uint32_t const present = driver_of(session);
    if (present < GN_LINK_CLIENTS && !continues) {
        (void)snprintf(ours->refusal, sizeof ours->refusal,
                       "another driver is connected; end it first, or connect as a visitor");
        return false;
    }
    if (continues && !gn_frame_ring_replay(&session->ring, theirs->last_sequence)) {
        (void)snprintf(ours->refusal, sizeof ours->refusal, "session %016llx never had a frame %u; begin a new session",
                       (unsigned long long)session->id, (unsigned)theirs->last_sequence);
        return false;
    }
    if (present < GN_LINK_CLIENTS) {
        dismiss(session, present, "its driver has reconnected");
        session->clients[present].out_length = 0;
        session->clients[present].out_sent = 0;
    }
    if (!continues) {
        session->id += session->open ? 1u : 0u;
        session->open = true;
        ++session->begun;
        gn_frame_ring_clear(&session->ring);
    }
    return true;
}

static bool admit(struct gn_session *session, uint32_t number, const gonio_Hello *theirs, gonio_Hello *ours) {
    if (theirs->schema_hash != GN_SCHEMA_HASH) {
        (void)snprintf(ours->refusal, sizeof ours->refusal,
                       "schema hashes differ: firmware %016llx, host %016llx; install both from the same release",
                       (unsigned long long)GN_SCHEMA_HASH, (unsigned long long)theirs->schema_hash);
        return false;
    }
    if (theirs->role == gonio_Role_ROLE_VISITOR) {
        session->clients[number].state = GN_CLIENT_VISITOR;
        return true;
    }
    if (theirs->role != gonio_Role_ROLE_DRIVER) {
        (void)snprintf(ours->refusal, sizeof ours->refusal, "HELLO names no role; say DRIVER or VISITOR");
        return false;
    }
    if (!admit_driver(session, theirs, ours)) {
        return false;
    }
    session->clients[number].state = GN_CLIENT_DRIVER;
    return true;
}

static void greet(struct gn_session *session, uint32_t number, const uint8_t *payload, uint32_t length) {
    gonio_Hello theirs = gonio_Hello_init_zero;
    gonio_Hello ours = gonio_Hello_init_zero;
    ours.schema_hash = GN_SCHEMA_HASH;
    (void)snprintf(ours.software, sizeof ours.software, "%s", GN_FIRMWARE_NAME);
    pb_istream_t stream = pb_istream_from_buffer(payload, length);
    /* A HELLO of another schema may break off half-way; the hash stands first in it and explains why. */
    bool const decoded = pb_decode(&stream, gonio_Hello_fields, &theirs);
    bool admitted = false;
    if (decoded || theirs.schema_hash != GN_SCHEMA_HASH) {
        admitted = admit(session, number, &theirs, &ours);
    } else {
        (void)snprintf(ours.refusal, sizeof ours.refusal, "HELLO cannot be decoded: %s", PB_GET_ERROR(&stream));
    }
    ours.session_id = admitted && session->clients[number].state == GN_CLIENT_DRIVER ? session->id : 0u;
    (void)gn_client_send(&session->clients[number], GN_FRAME_HELLO, 0u, gonio_Hello_fields, &ours);
    if (!admitted) {
        dismiss(session, number, ours.refusal);
    }
}

/* Numbers of the host run on without a jump; the first after HELLO may be any. */
static bool in_sequence(struct gn_client *client, uint32_t sequence) {
    bool const follows = sequence != 0u && (!client->host_numbered || sequence == client->host_sequence + 1u);
    client->host_numbered = true;
    client->host_sequence = sequence;
    return follows;
}

/* true: the frame is for the layers above. */
static bool handle(struct gn_session *session, uint32_t number, int64_t now_ns) {
    struct gn_client *client = &session->clients[number];
    struct gn_frame_header const header = gn_frame_header_at(client->decoder.bytes);
    if (client->state == GN_CLIENT_GREETING) {
        if (header.kind != GN_FRAME_HELLO) {
            dismiss(session, number, "its first frame is no HELLO");
            return false;
        }
        greet(session, number, client->decoder.bytes + GN_FRAME_HEADER_SIZE, header.length);
        session->heard_ns = client->state == GN_CLIENT_DRIVER ? now_ns : session->heard_ns;
        return false;
    }
    bool const driver = client->state == GN_CLIENT_DRIVER;
    if (driver) {
        session->heard_ns = now_ns;
        if (header.acknowledged != 0u && !gn_frame_ring_acknowledge(&session->ring, header.acknowledged)) {
            dismiss(session, number, "it acknowledges a frame that was not sent");
            return false;
        }
    }
    if (header.kind == GN_FRAME_ALIVE || header.kind == GN_FRAME_IDLE) {
        return false;
    }
    if (header.kind != GN_FRAME_REQUEST && !(header.kind == GN_FRAME_KNOTS && driver)) {
        dismiss(session, number, "it sends a kind of frame that it may not send");
        return false;
    }
    if (!in_sequence(client, header.sequence)) {
        dismiss(session, number, "its frame numbers jump");
        return false;
    }
    return true;
}

bool gn_session_receive(struct gn_session *session, int64_t now_ns, struct gn_inbound *inbound) {
    for (uint32_t number = 0; number < GN_LINK_CLIENTS; ++number) {
        struct gn_client *client = &session->clients[number];
        while (client->state != GN_CLIENT_LEAVING) {
            enum gn_frame_progress const progress = gn_client_next_frame(session, number);
            if (progress == GN_FRAME_INCOMPLETE) {
                break;
            }
            if (progress == GN_FRAME_REFUSED) {
                dismiss(session, number, gn_frame_error_text(client->decoder.error));
            } else if (handle(session, number, now_ns)) {
                struct gn_frame_header const header = gn_frame_header_at(client->decoder.bytes);
                *inbound = (struct gn_inbound){number, client->state == GN_CLIENT_DRIVER, header.kind,
                                               client->decoder.bytes + GN_FRAME_HEADER_SIZE, header.length};
                return true;
            }
        }
    }
    return false;
}

void gn_session_transmit(struct gn_session *session) {
    for (uint32_t number = 0; number < GN_LINK_CLIENTS; ++number) {
        struct gn_client *client = &session->clients[number];
        bool more = client->state != GN_CLIENT_ABSENT;
        while (more) {
            if (client->state == GN_CLIENT_DRIVER) {
                gn_client_gather(client, &session->ring);
            }
            bool const had_bytes = client->out_length > 0u;
            gn_client_write(session, number);
            more = had_bytes && client->out_length == 0u && client->state == GN_CLIENT_DRIVER;
        }
    }
    session->reads_left = READS_PER_CYCLE;
}

static void to_ring(struct gn_session *session, uint32_t kind, const pb_msgdesc_t *fields, const void *message,
                    uint32_t size_max) {
    pb_ostream_t stream = pb_ostream_from_buffer(gn_frame_ring_reserve(&session->ring, size_max), size_max);
    if (pb_encode(&stream, fields, message)) {
        gn_frame_ring_commit(&session->ring, kind, (uint32_t)stream.bytes_written);
    } else {
        session->log->write(session->log->context, GN_LOG_ERROR, "link: a message could not be encoded");
    }
}

void gn_session_event(struct gn_session *session, const gonio_Event *event) {
    if (session->open) {
        to_ring(session, GN_FRAME_EVENT, gonio_Event_fields, event, gonio_Event_size);
    }
}

void gn_session_block(struct gn_session *session, uint32_t kind, const uint8_t *payload, uint32_t length) {
    if (session->open) {
        memcpy(gn_frame_ring_reserve(&session->ring, length), payload, length);
        gn_frame_ring_commit(&session->ring, kind, length);
    }
}

void gn_session_reply(struct gn_session *session, uint32_t client, const gonio_Reply *reply) {
    if (client < GN_LINK_CLIENTS && session->clients[client].state == GN_CLIENT_VISITOR) {
        struct gn_client *visitor = &session->clients[client];
        if (!gn_client_send(visitor, GN_FRAME_REPLY, ++visitor->own_sequence, gonio_Reply_fields, reply)) {
            dismiss(session, client, "it does not read its replies");
        }
    } else if (session->open) {
        to_ring(session, GN_FRAME_REPLY, gonio_Reply_fields, reply, gonio_Reply_size);
    }
}
