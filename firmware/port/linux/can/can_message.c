/* can_message.c: recvmsg() and send() of the raw socket, and what the kernel says beside the frame. */
#include "can_message.h"

#include <errno.h>
#include <string.h>
#include <time.h>

#define SYNC_ID 0x080u

/* MSG_CONFIRM: sent through this very socket. Frames of other processes have MSG_DONTROUTE, and count as a node's. */
static enum gn_can_message_kind kind_of(const struct can_frame *frame, int flags, size_t length) {
    if (length != sizeof *frame) {
        return GN_MESSAGE_OTHER;
    }
    if (frame->can_id & CAN_ERR_FLAG) {
        return GN_MESSAGE_ERROR;
    }
    if ((frame->can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG)) || frame->can_dlc > CAN_MAX_DLEN) {
        return GN_MESSAGE_OTHER;
    }
    if ((flags & MSG_CONFIRM) == 0) {
        return GN_MESSAGE_DATA;
    }
    return frame->can_id == SYNC_ID ? GN_MESSAGE_ECHO : GN_MESSAGE_OTHER;
}

void gn_can_message_take_apart(struct gn_can_message *message, struct msghdr *header, size_t length) {
    message->kind = kind_of(&message->frame, header->msg_flags, length);
    message->stamped = false;
    message->counted = false;
    for (struct cmsghdr *c = CMSG_FIRSTHDR(header); c != NULL; c = CMSG_NXTHDR(header, c)) {
        struct timespec stamp;
        if (c->cmsg_level != SOL_SOCKET) {
            continue;
        }
        if (c->cmsg_type == SCM_TIMESTAMPNS && c->cmsg_len >= CMSG_LEN(sizeof stamp)) {
            memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
            message->real_ns = (int64_t)stamp.tv_sec * 1000000000 + stamp.tv_nsec;
            message->stamped = true;
        } else if (c->cmsg_type == SO_RXQ_OVFL && c->cmsg_len >= CMSG_LEN(sizeof message->lost)) {
            memcpy(&message->lost, CMSG_DATA(c), sizeof message->lost);
            message->counted = true;
        }
    }
}

int gn_can_message_receive(int fd, struct gn_can_message *message) {
    _Alignas(struct cmsghdr) char control[CMSG_SPACE(sizeof(struct timespec)) + CMSG_SPACE(sizeof(uint32_t))];
    struct iovec iov = {.iov_base = &message->frame, .iov_len = sizeof message->frame};
    struct msghdr header = {.msg_iov = &iov, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
    ssize_t const length = recvmsg(fd, &header, MSG_DONTWAIT);
    if (length < 0) {
        return errno == EAGAIN || errno == EINTR ? 0 : -errno;
    }
    if (length == 0) { /* the socket has ended */
        return -ENOTCONN;
    }
    gn_can_message_take_apart(message, &header, (size_t)length);
    return 1;
}

int gn_can_message_send(int fd, const struct gn_can_frame *frame) {
    struct can_frame out = {.can_id = frame->id, .can_dlc = frame->length};
    memcpy(out.data, frame->data, sizeof out.data);
    return send(fd, &out, sizeof out, MSG_DONTWAIT | MSG_NOSIGNAL) < 0 ? -errno : 0;
}
