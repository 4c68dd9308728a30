/* can_socket.c: a raw socket that stamps, echoes and reports errors; it survives its interface. */
#include "can_socket.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "can_interface.h"
#include "can_message.h"
#include "can_socket_state.h"
#include "shared.h"

/* The kernel's queue was full: two frames at 1 Mbit/s later there is room for one. */
#define RETRY_NS INT64_C(250000)
/* How often a lost interface is looked for: an operator does not notice, and it costs nine system calls. */
#define LOOK_NS INT64_C(100000000)
/* A second of a full bus at 1 Mbit/s, which no thread of ours ever sleeps. The kernel may grant less. */
#define RECEIVE_BUFFER_BYTES (8 << 20)
/* Reading both clocks takes some 100 ns; a reading that was interrupted is tried again. */
#define PAIR_WIDTH_NS 2000
#define PAIR_TRIES 3

static int64_t read_clock(clockid_t clock) {
    struct timespec time;
    (void)clock_gettime(clock, &time);
    return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

static struct gn_clock_pair read_pair(void) {
    struct gn_clock_pair pair;
    int tries = 0;
    do {
        pair.before_ns = read_clock(CLOCK_MONOTONIC);
        pair.real_ns = read_clock(CLOCK_REALTIME);
        pair.after_ns = read_clock(CLOCK_MONOTONIC);
    } while (pair.after_ns - pair.before_ns > PAIR_WIDTH_NS && ++tries < PAIR_TRIES);
    return pair;
}

static bool set_option(int fd, int level, int name, const void *value, socklen_t size) {
    return setsockopt(fd, level, name, value, size) == 0;
}

/* Data frames with 11-bit identifiers, all error frames, our own frames, stamps and the count of lost ones. */
static bool set_options(int fd) {
    struct can_filter const filter = {.can_id = 0, .can_mask = CAN_EFF_FLAG | CAN_RTR_FLAG};
    can_err_mask_t const errors = CAN_ERR_MASK;
    int const on = 1;
    int const bytes = RECEIVE_BUFFER_BYTES;
    if (!set_option(fd, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes)) {
        (void)set_option(fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes); /* as much as an ordinary user may have */
    }
    return set_option(fd, SOL_CAN_RAW, CAN_RAW_FILTER, &filter, sizeof filter) &&
           set_option(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) &&
           set_option(fd, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &on, sizeof on) &&
           set_option(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) &&
           set_option(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
}

/* A bound socket, or -1 and errno. */
static int open_bound(int index) {
    int const fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
    if (fd < 0) {
        return -1;
    }
    struct sockaddr_can const address = {.can_family = AF_CAN, .can_ifindex = index};
    if (!set_options(fd) || bind(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        int const why = errno;
        (void)close(fd);
        errno = why;
        return -1;
    }
    return fd;
}

void gn_can_socket_adopt(struct gn_can_socket *can, int fd) {
    struct gn_clock_pair const pair = read_pair();
    uint32_t const steps = can->clock.steps;
    can->fd = fd;
    can->lost_before += can->lost;
    can->lost = 0;
    can->retry_ns = 0;
    gn_clock_map_init(&can->clock, &pair);
    can->clock.steps = steps;
}

struct gn_can_socket *gn_can_socket_open(const struct gn_can_settings *settings, char *error, size_t error_size) {
    static struct gn_can_socket instance;
    const char *const name = settings->interface;
    struct gn_can_look const look = gn_can_interface_look(GN_NET_FOLDER, name);
    if (look.index == 0) {
        (void)snprintf(error, error_size, "no CAN interface %s: see `ip link` for its name, load its driver", name);
        return NULL;
    }
    if (!look.is_can) {
        (void)snprintf(error, error_size, "%s is no CAN interface: see `ip link show type can`", name);
        return NULL;
    }
    int const fd = open_bound(look.index);
    if (fd < 0) {
        (void)snprintf(error, error_size, "CAN interface %s cannot be opened: %s", name, strerror(errno));
        return NULL;
    }
    instance = (struct gn_can_socket){.settings = *settings, .net_folder = GN_NET_FOLDER, .index = look.index};
    instance.health.state = look.up ? gn_can_interface_state(look.index) : GN_CAN_DOWN;
    instance.health.bus_off_ns = read_clock(CLOCK_MONOTONIC);
    gn_can_socket_adopt(&instance, fd);
    return &instance;
}

void gn_can_socket_close(struct gn_can_socket *can) {
    if (can->fd >= 0) {
        (void)close(can->fd);
    }
    can->fd = -1;
}

int gn_can_socket_fd(const struct gn_can_socket *can) {
    return can->fd;
}

static void interface_lost(struct gn_can_socket *can, int why) {
    gn_bus_health_on_interface(&can->health, false);
    gn_transmit_queue_clear(&can->queue);
    can->look_ns = 0;
    if (why != ENETDOWN) { /* removed: the socket would never be bound to what comes back */
        gn_can_socket_close(can);
    }
}

/* Room enough is found out by trying: a raw CAN socket is always writable to poll(). */
static void flush(struct gn_can_socket *can) {
    const struct gn_can_frame *frame = NULL;
    while (can->retry_ns == 0 && (frame = gn_transmit_queue_front(&can->queue)) != NULL) {
        int const result = gn_can_message_send(can->fd, frame);
        if (result == -ENOBUFS || result == -EAGAIN || result == -EINTR) {
            can->retry_ns = read_clock(CLOCK_MONOTONIC) + RETRY_NS;
        } else if (result != 0) {
            interface_lost(can, -result);
        } else {
            gn_transmit_queue_pop(&can->queue);
        }
    }
}

static int port_send(void *context, const struct gn_can_frame *frame) {
    struct gn_can_socket *can = context;
    if (!gn_bus_health_can_send(&can->health) || !gn_transmit_queue_push(&can->queue, frame)) {
        return -1;
    }
    flush(can);
    return 0;
}

static void deliver(struct gn_can_socket *can, const struct gn_can_message *message, int64_t now_ns,
                    struct gn_can_frame *frame) {
    *frame = (struct gn_can_frame){
        .id = message->frame.can_id,
        .length = message->frame.can_dlc,
        .own_echo = message->kind == GN_MESSAGE_ECHO,
        .stamp_ns = now_ns,
        .stamp_by_arrival = true,
    };
    memcpy(frame->data, message->frame.data, sizeof frame->data);
    if (message->stamped) {
        frame->stamp_ns = gn_clock_map_stamp(&can->clock, message->real_ns, now_ns, &frame->stamp_by_arrival);
    }
    gn_bus_health_on_data(&can->health, now_ns);
}

static void on_error_frame(struct gn_can_socket *can, const struct can_frame *frame, int64_t now_ns) {
    gn_bus_health_on_error(&can->health, frame, now_ns);
    if (!gn_bus_health_can_send(&can->health)) {
        gn_transmit_queue_clear(&can->queue);
    }
}

static int port_receive(void *context, struct gn_can_frame *frame) {
    struct gn_can_socket *can = context;
    struct gn_can_message message;
    while (can->fd >= 0) {
        int const result = gn_can_message_receive(can->fd, &message);
        struct gn_clock_pair const pair = read_pair();
        gn_clock_map_update(&can->clock, &pair);
        if (result == 0) {
            /* before_ns: a frame may have come since */
            gn_clock_map_drained(&can->clock, pair.before_ns);
            return 0;
        }
        if (result < 0) {
            interface_lost(can, -result);
            continue;
        }
        if (message.counted) {
            can->lost = message.lost;
        }
        if (message.kind == GN_MESSAGE_ERROR) {
            on_error_frame(can, &message.frame, pair.after_ns);
        } else if (message.kind != GN_MESSAGE_OTHER) {
            deliver(can, &message, pair.after_ns, frame);
            return 1;
        }
    }
    return 0;
}

static void port_status(void *context, struct gn_can_status *status) {
    const struct gn_can_socket *can = context;
    *status = (struct gn_can_status){
        .state = can->health.state,
        .receive_overflows = can->lost_before + can->lost + can->health.chip_overflows,
        .error_frames = can->health.error_frames,
        .setpoints_dropped = can->queue.setpoints_dropped,
        .bus_offs = can->health.bus_offs,
        .clock_steps = can->clock.steps,
        .sync_stamp_sigma_us = can->settings.sync_stamp_sigma_us,
    };
}

void gn_can_socket_port(struct gn_can_socket *can, struct gn_can_port *port) {
    *port = (struct gn_can_port){.context = can, .send = port_send, .receive = port_receive, .status = port_status};
}

/* Down: it comes up by itself under the same socket. Gone: another socket when there is one of its name again. */
static void look_for_interface(struct gn_can_socket *can) {
    struct gn_can_look const look = gn_can_interface_look(can->net_folder, can->settings.interface);
    if (can->fd >= 0 && look.index != can->index) {
        gn_can_socket_close(can);
    }
    if (look.index == 0 || !look.is_can || !look.up) {
        return;
    }
    if (can->fd < 0) {
        int const fd = open_bound(look.index);
        if (fd < 0) {
            return;
        }
        can->index = look.index;
        gn_can_socket_adopt(can, fd);
    }
    gn_bus_health_on_interface(&can->health, true);
}

int64_t gn_can_socket_process(struct gn_can_socket *can, int64_t now_ns) {
    if (can->health.state == GN_CAN_DOWN) {
        if (now_ns >= can->look_ns) {
            can->look_ns = now_ns + LOOK_NS;
            look_for_interface(can);
        }
        return can->health.state == GN_CAN_DOWN ? can->look_ns : GN_NEVER_NS;
    }
    if (can->retry_ns != 0 && now_ns >= can->retry_ns) {
        can->retry_ns = 0;
        flush(can);
    }
    return can->retry_ns != 0 ? can->retry_ns : GN_NEVER_NS;
}
