/* fuzz_can_input.c: any CAN frames, edges and requests against the real-time thread, with drives that sometimes obey.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "motion.h"
#include "motion_state.h"

#define QUEUE 64u
#define AXES 2u

struct bench {
    struct gn_can_frame queue[QUEUE];
    uint32_t head, tail;
    uint32_t written[AXES + 1u];
    bool obey;
    struct gn_edge edge;
    bool edge_waits;
    int64_t now_ns;
};

static void arrive(struct bench *bench, struct gn_can_frame frame) {
    if (bench->tail - bench->head < QUEUE) {
        frame.stamp_ns = bench->now_ns;
        bench->queue[bench->tail++ % QUEUE] = frame;
    }
}

/* An answer that makes boot go on: writes succeed and read back. */
static void answer_sdo(struct bench *bench, const struct gn_can_frame *request) {
    uint32_t const node = request->id - 0x600u;
    struct gn_can_frame answer = *request;
    answer.id = 0x580u + node;
    uint16_t const index = (uint16_t)(request->data[1] | request->data[2] << 8);
    if ((request->data[0] & 0xE0u) == 0x20u) {
        memcpy(&bench->written[node], request->data + 4, 4);
        answer.data[0] = 0x60;
    } else {
        uint32_t value = bench->written[node];
        value = index == 0x1000u ? 0x0192u : value;
        value = index == 0x608Fu ? (request->data[3] == 1u ? 4000u : 1u) : value;
        answer.data[0] = 0x43;
        memcpy(answer.data + 4, &value, 4);
    }
    arrive(bench, answer);
}

static int send(void *context, const struct gn_can_frame *frame) {
    struct bench *bench = context;
    if (frame->length > 8u || frame->id > 0x7FFu) {
        __builtin_trap();
    }
    if (!bench->obey) {
        return 0;
    }
    if (frame->id == 0x080u) {
        struct gn_can_frame echo = *frame;
        echo.own_echo = true;
        arrive(bench, echo);
        for (uint32_t node = 1; node <= AXES; node++) {
            arrive(bench, (struct gn_can_frame){.id = 0x180u + node, .length = 6, .data = {0x27, 0x14}});
        }
    } else if (frame->id > 0x600u && frame->id <= 0x600u + AXES) {
        answer_sdo(bench, frame);
    } else if (frame->id == 0x000u && frame->data[1] <= AXES) {
        uint8_t const state = frame->data[0] == 0x01u ? 0x05u : 0x00u;
        arrive(bench, (struct gn_can_frame){.id = 0x700u + frame->data[1], .length = 1, .data = {state}});
    }
    return 0;
}

static int receive(void *context, struct gn_can_frame *frame) {
    struct bench *bench = context;
    if (bench->head == bench->tail) {
        return 0;
    }
    *frame = bench->queue[bench->head++ % QUEUE];
    return 1;
}

static void status(void *context, struct gn_can_status *status) {
    (void)context;
    *status = (struct gn_can_status){0};
}

static int receive_edge(void *context, struct gn_edge *edge) {
    struct bench *bench = context;
    bool const waits = bench->edge_waits;
    bench->edge_waits = false;
    *edge = bench->edge;
    return waits;
}

static bool level(void *context, uint32_t line) {
    (void)context;
    return line != GN_LINE_STROBE;
}

static void set(void *context, uint32_t output, bool on) {
    (void)context;
    (void)output;
    (void)on;
}

static void pulse(void *context) {
    (void)context;
}

static void operator_done(void *context, uint32_t action) {
    (void)context;
    (void)action;
}

static void write_log(void *context, enum gn_log_level log_level, const char *text) {
    (void)context;
    (void)log_level;
    if (strlen(text) == 0u) {
        __builtin_trap();
    }
}

static void request(struct gn_shared *shared, gonio_Request body) {
    struct gn_command command = {.request = body};
    (void)gn_ring_push(&shared->commands, &command);
}

static void configure(struct gn_shared *shared) {
    gonio_Request configure_request = {.id = 1, .which_body = gonio_Request_configure_tag};
    configure_request.body.configure = (gonio_Configure){
        .axis_count = AXES,
        .sync_period_us = 2000,
        .sync_window_us = 1500,
        .firmware_heartbeat_ms = 100,
        .drive_heartbeat_ms = 100,
        .heartbeat_timeout_ms = 300,
        .rpdo_deadline_syncs = 3,
        .sdo_timeout_ms = 20,
        .boot_timeout_ms = 50,
        .expiry_ms = 3000,
    };
    request(shared, configure_request);
    for (uint32_t axis = 0; axis < AXES; axis++) {
        gonio_Request axis_request = {.id = 2, .which_body = gonio_Request_configure_axis_tag};
        axis_request.body.configure_axis = (gonio_AxisConfig){
            .axis = axis,
            .name = "axis",
            .node = axis + 1u,
            .counts_per_deg = 10.0,
            .min_counts = -1e6,
            .max_counts = 1e6,
            .max_velocity_counts_per_s = 1e5,
            .max_acceleration_counts_per_s2 = 1e6,
            .homing_timeout_ms = 100,
            .following_error_counts = 50,
            .counts_per_turn = 4000,
            .quick_stop_deceleration_counts_per_s2 = 1000,
            .brake = axis == 0u,
        };
        request(shared, axis_request);
    }
}

static void run(struct gn_motion *motion, struct bench *bench, struct gn_shared *shared) {
    union {
        struct gn_notice notice;
        struct gn_pose pose;
    } out;
    if (gn_motion_process(motion, bench->now_ns) <= bench->now_ns) {
        __builtin_trap(); /* it would be called for ever */
    }
    while (gn_ring_pop(&shared->notices, &out.notice)) {
        if (!out.notice.is_reply && out.notice.as.event.time_ns != bench->now_ns) {
            __builtin_trap();
        }
    }
    while (gn_ring_pop(&shared->poses, &out.pose)) {
        if (out.pose.valid >> AXES) {
            __builtin_trap();
        }
    }
}

/* One of the short requests and a few knots, by a byte. */
static void ask(struct gn_shared *shared, const uint8_t *data) {
    static const pb_size_t bodies[] = {gonio_Request_boot_tag,         gonio_Request_home_tag,
                                       gonio_Request_motion_begin_tag, gonio_Request_clear_fault_tag,
                                       gonio_Request_release_tag,      gonio_Request_sdo_read_tag,
                                       gonio_Request_set_output_tag,   gonio_Request_get_info_tag};
    gonio_Request body = {.id = 3, .which_body = bodies[data[0] % 8u]};
    if (body.which_body == gonio_Request_home_tag) {
        body.body.home.axis_mask = data[1];
    } else if (body.which_body == gonio_Request_motion_begin_tag) {
        body.body.motion_begin = (gonio_MotionBegin){.path_id = data[1], .knot_count = data[2], .start = true};
    } else if (body.which_body == gonio_Request_sdo_read_tag) {
        body.body.sdo_read = (gonio_SdoRead){.node = data[1] % 4u, .index = data[2], .subindex = data[3]};
    } else if (body.which_body == gonio_Request_set_output_tag) {
        body.body.set_output = (gonio_SetOutput){.output = (gonio_Output)(data[1] % 4u), .on = data[2] & 1u};
    }
    request(shared, body);
    for (uint32_t i = 0; i < data[4] % 4u; i++) {
        struct gn_knot_item item = {.path_id = data[1], .number = i};
        item.knot.time_ns = (int64_t)i * data[5] * 10000000;
        item.knot.position_counts[0] = (double)i * data[6];
        (void)gn_ring_push(&shared->knots, &item);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Each step is twelve bytes: what, time step, identifier, length and eight bytes. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct gn_shared shared;
    static struct bench bench;
    bench = (struct bench){.now_ns = 1000000, .obey = true};
    struct gn_port const port = {
        .can = {.context = &bench, .send = send, .receive = receive, .status = status},
        .edge = {.context = &bench, .receive = receive_edge, .level = level},
        .out = {.context = &bench, .set = set, .pulse_watchdog = pulse, .operator_done = operator_done},
        .log = {.context = &bench, .write = write_log},
    };
    gn_shared_init(&shared);
    struct gn_motion *motion = gn_motion_init(&port, &shared);
    configure(&shared);
    run(motion, &bench, &shared);
    for (; size >= 12u; data += 12, size -= 12u) {
        struct gn_can_frame frame = {.id = (uint32_t)(data[2] | data[3] << 8) & 0x7FFu, .length = data[3] >> 4};
        memcpy(frame.data, data + 4, 8);
        frame.length = frame.length > 8u ? 8u : frame.length;
        switch (data[0] % 8u) {
        case 0:
            ask(&shared, data + 4);
            break;
        case 1:
            bench.obey = !bench.obey;
            break;
        case 2:
            bench.edge =
                (struct gn_edge){.line = data[4], .number = 1, .rising = data[5] & 1u, .stamp_ns = bench.now_ns};
            bench.edge_waits = true;
            break;
        case 3:
            frame.own_echo = true;
            arrive(&bench, frame);
            break;
        case 4:
            shared.host_heard_ns = bench.now_ns;
            break;
        case 5: /* time passes in cycles */
            for (uint32_t i = 0; i < data[4] % 64u; i++) {
                bench.now_ns += 2000000;
                run(motion, &bench, &shared);
            }
            break;
        default:
            arrive(&bench, frame);
            break;
        }
        bench.now_ns += (int64_t)data[1] * 20000;
        run(motion, &bench, &shared);
    }
    return 0;
}
