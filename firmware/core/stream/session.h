/* session.h: the clients on the link: HELLO, one driver with replay, visitors, and what leaves for each of them. */
#ifndef GONIO_SESSION_H
#define GONIO_SESSION_H

#include <stdbool.h>
#include <stdint.h>

#include "frame.h"
#include "frame_ring.h"
#include "gonio.pb.h"
#include "link.h"
#include "log.h"

#define GN_FIRMWARE_NAME "gonio firmware 0.1.0"
#define GN_SESSION_RING_BYTES                                                                                          \
    (1u << 20) /* more than 10 s of samples at 1 kHz, poses at 500 Hz and events: about 40 kB/s */
#define GN_SESSION_OUT_BYTES 32768u
#define GN_SESSION_IN_BYTES 4096u

enum gn_client_state {
    GN_CLIENT_ABSENT = 0,
    GN_CLIENT_GREETING = 1, /* connected, HELLO awaited */
    GN_CLIENT_DRIVER = 2,
    GN_CLIENT_VISITOR = 3,
    GN_CLIENT_LEAVING = 4, /* closed as soon as the last bytes are out */
};

struct gn_client {
    enum gn_client_state state;
    bool host_numbered;     /* a numbered frame has come since HELLO */
    uint32_t host_sequence; /* last numbered frame of this client */
    uint32_t own_sequence;  /* last frame numbered for a visitor; the driver's are numbered by the ring */
    uint32_t in_length, in_taken;
    uint32_t out_length, out_sent;
    struct gn_frame_decoder decoder;
    uint8_t in[GN_SESSION_IN_BYTES];
    uint8_t out[GN_SESSION_OUT_BYTES];
};

struct gn_session {
    const struct gn_link_port *link;
    const struct gn_log_port *log;
    uint64_t id;
    bool open;           /* a driver has said HELLO; from then on frames are kept for it */
    uint32_t begun;      /* sessions so far; a change is a new driver that knows nothing of the old one */
    int64_t heard_ns;    /* when the driver was last heard; 0: never */
    uint32_t reads_left; /* in this cycle, so that no client starves the rest */
    struct gn_frame_ring ring;
    struct gn_client clients[GN_LINK_CLIENTS];
    uint8_t ring_bytes[GN_SESSION_RING_BYTES];
};

/* A frame for the layers above: REQUEST from anyone, KNOTS from the driver. Valid until the next receive. */
struct gn_inbound {
    uint32_t client;
    bool from_driver;
    uint32_t kind;
    const uint8_t *payload;
    uint32_t length;
};

void gn_session_init(struct gn_session *session, const struct gn_link_port *link, const struct gn_log_port *log,
                     uint64_t id);
/* Reads on until there is a frame for the layers above. false: nothing more for now. */
bool gn_session_receive(struct gn_session *session, int64_t now_ns, struct gn_inbound *inbound);
/* Writes what the link takes. */
void gn_session_transmit(struct gn_session *session);

bool gn_session_driver_connected(const struct gn_session *session);
/* To the driver's session; nothing before there is one. */
void gn_session_event(struct gn_session *session, const gonio_Event *event);
void gn_session_block(struct gn_session *session, uint32_t kind, const uint8_t *payload, uint32_t length);
/* To a visitor, or, for any other client number, to the driver's session. */
void gn_session_reply(struct gn_session *session, uint32_t client, const gonio_Reply *reply);

#endif
