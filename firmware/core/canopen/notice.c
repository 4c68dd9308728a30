/* notice.c: fills replies and events into the notice ring. */
#include "notice.h"

#include <stdio.h>

void gn_reply_with(struct gn_motion *motion, const gonio_Reply *reply) {
    struct gn_notice notice = {.is_reply = true};
    notice.as.reply = *reply;
    (void)gn_ring_push(&motion->shared->notices, &notice); /* the ring counts what it drops */
}

void gn_reply(struct gn_motion *motion, uint32_t request_id, gonio_ReplyCode code, const char *text) {
    gonio_Reply reply = {.id = request_id, .code = code};
    (void)snprintf(reply.text, sizeof reply.text, "%s", text);
    gn_reply_with(motion, &reply);
}

void gn_event(struct gn_motion *motion, gonio_Event *event) {
    struct gn_notice notice = {.is_reply = false};
    event->time_ns = motion->now_ns;
    notice.as.event = *event;
    (void)gn_ring_push(&motion->shared->notices, &notice);
}

void gn_event_path(struct gn_motion *motion, gonio_PathEnd end) {
    gonio_Event event = {.which_body = gonio_Event_path_tag};
    event.body.path =
        (gonio_PathState){.path_id = motion->path.path_id, .end = end, .path_time_ns = motion->path.time_ns};
    gn_event(motion, &event);
}

void gn_notice_log(struct gn_motion *motion, uint32_t level, const char *text) {
    gonio_Event event = {.which_body = gonio_Event_log_tag};
    event.body.log.level = level;
    (void)snprintf(event.body.log.text, sizeof event.body.log.text, "%.*s", (int)sizeof event.body.log.text - 1, text);
    gn_event(motion, &event);
}

uint32_t gn_known_mask(const struct gn_motion *motion) {
    uint32_t mask = 0;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        mask |= motion->axes[i].homed ? 1u << i : 0u;
    }
    return mask;
}

void gn_event_status(struct gn_motion *motion) {
    gonio_Event event = {.which_body = gonio_Event_status_tag};
    gonio_Status *status = &event.body.status;
    *status = (gonio_Status){
        .state = motion->state,
        .path_id = motion->path.path_id,
        .path_time_ns = motion->path.time_ns,
        .knots_used = motion->path.used,
        .knot_credit = gn_path_credit(&motion->path),
        .clock_locked = __atomic_load_n(&motion->shared->clock_locked, __ATOMIC_RELAXED) != 0u,
        .position_counts_count = (pb_size_t)motion->cycle.axis_count,
        .position_known_mask = gn_known_mask(motion),
        .shutter_open = motion->shutter_open,
        .lamp_on = motion->lamp_on,
        .acquiring = __atomic_load_n(&motion->shared->acquiring, __ATOMIC_RELAXED) != 0u,
        .inputs = motion->inputs,
        .feed = motion->path.state == GN_PATH_IDLE ? 0.0 : motion->path.feed,
    };
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        status->position_counts[i] = motion->axes[i].measured_counts;
    }
    gn_event(motion, &event);
}

void gn_operation_done(struct gn_motion *motion, gonio_ReplyCode code, const char *text) {
    if (motion->operation.kind == GN_OPERATION_NONE) {
        return;
    }
    gonio_Event event = {.which_body = gonio_Event_done_tag};
    event.body.done.request_id = motion->operation.request_id;
    event.body.done.code = code;
    (void)snprintf(event.body.done.text, sizeof event.body.done.text, "%s", text);
    motion->operation = (struct gn_operation){0};
    gn_event(motion, &event);
}
