/* selftest_client.h: the self-test's host: one connection over loopback TCP, and the frames that it needs. */
#ifndef GONIO_SELFTEST_CLIENT_H
#define GONIO_SELFTEST_CLIENT_H

#include <stdbool.h>
#include <stdint.h>

#include "frame.h"
#include "gonio.pb.h"

struct gn_selftest_client {
    int socket;
    uint32_t sequence;
    uint32_t acknowledged;
    struct gn_frame_decoder decoder;
    uint8_t in[4096];
    uint32_t filled;
    uint32_t taken;
};

/* Connects and says HELLO. false: no connection, or refused; `reply` holds what the firmware said. */
bool gn_selftest_connect(struct gn_selftest_client *client, uint16_t port, gonio_Role role, gonio_Hello *answer);
bool gn_selftest_request(struct gn_selftest_client *client, const gonio_Request *request);
/* The next Reply or Event; false: nothing came in time, or no good frame. */
bool gn_selftest_next(struct gn_selftest_client *client, bool *is_reply, gonio_Reply *reply, gonio_Event *event);
/* The reply to a request; events before it are passed over. */
bool gn_selftest_reply(struct gn_selftest_client *client, uint32_t id, gonio_Reply *reply);
void gn_selftest_disconnect(struct gn_selftest_client *client);

#endif
