/* can_message.h: one message of the raw socket taken apart: frame, whose it is, stamp, count of lost ones. */
#ifndef GONIO_CAN_MESSAGE_H
#define GONIO_CAN_MESSAGE_H

#include <linux/can.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

#include "can.h"

enum gn_can_message_kind {
    GN_MESSAGE_DATA = 0,  /* a node's, or another process's on this machine */
    GN_MESSAGE_ECHO = 1,  /* our own SYNC, as it was on the bus */
    GN_MESSAGE_ERROR = 2, /* CAN_ERR_FLAG */
    GN_MESSAGE_OTHER = 3, /* not for the core: our other echoes, extended and remote frames */
};

struct gn_can_message {
    enum gn_can_message_kind kind;
    struct can_frame frame;
    bool stamped;
    int64_t real_ns; /* CLOCK_REALTIME */
    bool counted;
    uint32_t lost; /* by the socket's full queue, since it was opened */
};

/* Takes what recvmsg() filled in; iov 0 points to message->frame. */
void gn_can_message_take_apart(struct gn_can_message *message, struct msghdr *header, size_t length);
/* 1: one taken, 0: none waiting, else -errno. Never waits. */
int gn_can_message_receive(int fd, struct gn_can_message *message);
/* 0, else -errno. Never waits. */
int gn_can_message_send(int fd, const struct gn_can_frame *frame);

#endif
