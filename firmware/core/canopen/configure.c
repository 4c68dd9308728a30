/* configure.c: the checks of a configuration; what is already set may be set again at any time. */
#include "configure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "notice.h"
#include "pb_encode.h"
#include "ride.h"

#define COUNTS_LIMIT 2147483647.0

/* Equal on the wire is equal: structures may differ in their padding. */
static bool same(const pb_msgdesc_t *fields, const void *a, const void *b) {
    uint8_t bytes[2][sizeof(gonio_AxisConfig) * 2u] = {{0}};
    pb_ostream_t first = pb_ostream_from_buffer(bytes[0], sizeof bytes[0]);
    pb_ostream_t second = pb_ostream_from_buffer(bytes[1], sizeof bytes[1]);
    return pb_encode(&first, fields, a) && pb_encode(&second, fields, b) &&
           first.bytes_written == second.bytes_written && memcmp(bytes[0], bytes[1], first.bytes_written) == 0;
}

/* May the set-up change now? If not, replies. */
static bool changeable(struct gn_motion *motion, uint32_t request_id) {
    bool enabled = false;
    for (uint32_t i = 0; i < GN_AXES; i++) {
        enabled = enabled || motion->axes[i].enabled;
    }
    bool const idle = motion->state == gonio_InstrumentState_STATE_UNCONFIGURED ||
                      motion->state == gonio_InstrumentState_STATE_CONFIGURED ||
                      motion->state == gonio_InstrumentState_STATE_UNHOMED;
    if (idle && !enabled && motion->operation.kind == GN_OPERATION_NONE) {
        return true;
    }
    gn_reply(
        motion, request_id, gonio_ReplyCode_REPLY_REFUSED,
        "the configuration differs from the one in use: release the drives (or clear the fault) before changing it");
    return false;
}

static void update_state(struct gn_motion *motion) {
    bool complete = motion->configured;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        complete = complete && motion->axes[i].configured;
    }
    motion->state = complete ? gonio_InstrumentState_STATE_CONFIGURED : gonio_InstrumentState_STATE_UNCONFIGURED;
}

struct range {
    const char *name;
    uint32_t value, low, high;
};

/* NULL, or the sentence. */
static const char *out_of_range(const struct range *ranges, uint32_t count, char *text, uint32_t size) {
    for (uint32_t i = 0; i < count; i++) {
        if (ranges[i].value < ranges[i].low || ranges[i].value > ranges[i].high) {
            (void)snprintf(text, size, "%s is %lu; it must be %lu to %lu", ranges[i].name,
                           (unsigned long)ranges[i].value, (unsigned long)ranges[i].low, (unsigned long)ranges[i].high);
            return text;
        }
    }
    return NULL;
}

/* The host must be able to speak some times before the stop begins. */
#define LEAST_PATIENCE_MS 500u

static const char *expiry_problem(const gonio_Configure *c, char *text, uint32_t size) {
    uint32_t const stop_ms = gn_ride_stop_ms(c);
    uint32_t const least_ms = stop_ms + LEAST_PATIENCE_MS;
    if (c->expiry_ms >= least_ms) {
        return NULL;
    }
    (void)snprintf(text, size, "expiry_ms is %lu; a stop may take %lu and begins after %lu at the earliest: set %lu",
                   (unsigned long)c->expiry_ms, (unsigned long)stop_ms, (unsigned long)LEAST_PATIENCE_MS,
                   (unsigned long)least_ms);
    return text;
}

/* 0x60C2 holds the period as 1 to 255 units of a power of ten. */
static bool period_fits(uint32_t period_us) {
    while (period_us % 10u == 0u) {
        period_us /= 10u;
    }
    return period_us <= 255u;
}

static const char *cycle_problem(const gonio_Configure *c, char *text, uint32_t size) {
    const struct range ranges[] = {
        {"axis_count", c->axis_count, 1, GN_AXES},
        {"sync_period_us", c->sync_period_us, 1000, 100000}, /* ten PDOs and some SDOs need a millisecond at 1 Mbit/s */
        {"sync_window_us", c->sync_window_us, 100, c->sync_period_us},
        {"firmware_heartbeat_ms", c->firmware_heartbeat_ms, 10, 10000},
        {"drive_heartbeat_ms", c->drive_heartbeat_ms, 10, 10000},
        {"heartbeat_timeout_ms", c->heartbeat_timeout_ms, c->drive_heartbeat_ms + 1u, 60000},
        {"rpdo_deadline_syncs", c->rpdo_deadline_syncs, 2, 100},
        {"sdo_timeout_ms", c->sdo_timeout_ms, 5, 10000},
        {"boot_timeout_ms", c->boot_timeout_ms, 10, 60000},
        {"expiry_ms", c->expiry_ms, 0, 60000},
    };
    const char *problem = out_of_range(ranges, sizeof ranges / sizeof ranges[0], text, size);
    if (problem == NULL && !period_fits(c->sync_period_us)) {
        return "sync_period_us does not fit into 0x60C2: use at most 255 times a power of ten";
    }
    return problem != NULL ? problem : expiry_problem(c, text, size);
}

void gn_configure_request(struct gn_motion *motion, uint32_t request_id, const gonio_Configure *configure) {
    char text[120];
    if (motion->configured && same(gonio_Configure_fields, configure, &motion->cycle)) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_OK, "");
        return;
    }
    const char *problem = cycle_problem(configure, text, sizeof text);
    if (problem != NULL) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_INVALID, problem);
        return;
    }
    if (!changeable(motion, request_id)) {
        return;
    }
    if (!motion->configured) {
        motion->next_cycle_ns = motion->now_ns;
    }
    motion->cycle = *configure;
    motion->configured = true;
    motion->heartbeat.period_ns = (int64_t)configure->firmware_heartbeat_ms * 1000000;
    for (uint32_t i = 0; i < GN_AXES; i++) {
        motion->axes[i].sdo.timeout_ns = (int64_t)configure->sdo_timeout_ms * 1000000;
    }
    update_state(motion);
    gn_reply(motion, request_id, gonio_ReplyCode_REPLY_OK, "");
}

static bool is_count(double value) {
    return isfinite(value) && fabs(value) <= COUNTS_LIMIT;
}

/* CiA 402: methods 1 and 17 search the limit switch at the negative end, 2 and 18 the one at the positive end. The
 * switch's position must then lie at that end of the travel; with the wrong sign of counts_per_deg it lies at the
 * other. In the middle half of the travel the switch is at neither. Methods with a switch within the travel, or none,
 * say nothing about it. */
static const char *sign_problem(const gonio_AxisConfig *a, char *text, uint32_t size) {
    bool const negative = a->homing_method == 1 || a->homing_method == 17;
    bool const positive = a->homing_method == 2 || a->homing_method == 18;
    double const quarter = 0.25 * (a->max_counts - a->min_counts);
    double const beyond_middle = a->home_offset_counts - 0.5 * (a->min_counts + a->max_counts);
    if (!(negative && beyond_middle > quarter) && !(positive && beyond_middle < -quarter)) {
        return NULL;
    }
    (void)snprintf(
        text, size,
        "homing method %ld goes to the %s end in counts, the switch (%ld) is at the other: check the sign of "
        "counts_per_deg, the method and switch_deg",
        (long)a->homing_method, negative ? "negative" : "positive", (long)a->home_offset_counts);
    return text;
}

static const char *axis_problem(const struct gn_motion *motion, const gonio_AxisConfig *a, char *text, uint32_t size) {
    const struct range ranges[] = {
        {"axis", a->axis, 0, GN_AXES - 1u},
        {"node", a->node, 1, 126},
        {"homing_timeout_ms", a->homing_timeout_ms, 1, 3600000},
        {"following_error_counts", a->following_error_counts, 1, 0x7FFFFFFFu},
        {"following_error_timeout_ms", a->following_error_timeout_ms, 0, 0xFFFFu},
        {"counts_per_turn", a->counts_per_turn, 1, UINT32_MAX},
        {"quick_stop_deceleration_counts_per_s2", a->quick_stop_deceleration_counts_per_s2, 1, UINT32_MAX},
    };
    const char *problem = out_of_range(ranges, sizeof ranges / sizeof ranges[0], text, size);
    if (problem != NULL) {
        return problem;
    }
    if (!is_count(a->counts_per_deg) || a->counts_per_deg == 0.0) {
        return "counts_per_deg must be a number other than 0";
    }
    if (!is_count(a->min_counts) || !is_count(a->max_counts) || !(a->min_counts < a->max_counts)) {
        return "min_counts must be less than max_counts, both within 32 bits";
    }
    if (!is_count(a->max_velocity_counts_per_s) || !is_count(a->max_acceleration_counts_per_s2) ||
        !(a->max_velocity_counts_per_s > 0.0) || !(a->max_acceleration_counts_per_s2 > 0.0)) {
        return "velocity and acceleration limits must be more than 0";
    }
    for (uint32_t i = 0; i < GN_AXES; i++) {
        if (i != a->axis && motion->axes[i].configured && motion->axes[i].config.node == a->node) {
            (void)snprintf(text, size, "node %u is already axis %u", (unsigned)a->node, (unsigned)i);
            return text;
        }
    }
    return sign_problem(a, text, size);
}

void gn_configure_axis_request(struct gn_motion *motion, uint32_t request_id, const gonio_AxisConfig *config) {
    char problem_text[200];
    char text[240];
    const char *problem = axis_problem(motion, config, problem_text, sizeof problem_text);
    if (problem != NULL) {
        (void)snprintf(text, sizeof text, "axis %u (%.23s): %s", (unsigned)config->axis, config->name, problem);
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_INVALID, text);
        return;
    }
    struct gn_axis *axis = &motion->axes[config->axis];
    if (axis->configured && same(gonio_AxisConfig_fields, config, &axis->config)) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_OK, "");
        return;
    }
    if (!changeable(motion, request_id)) {
        return;
    }
    axis->config = *config;
    axis->configured = true;
    axis->node = (struct gn_node){0};
    axis->boot = (struct gn_boot){0};
    gn_sdo_init(&axis->sdo, config->node, (int64_t)motion->cycle.sdo_timeout_ms * 1000000);
    update_state(motion);
    gn_reply(motion, request_id, gonio_ReplyCode_REPLY_OK, "");
}

void gn_configure_zone_request(struct gn_motion *motion, uint32_t request_id, const gonio_Zone *zone) {
    if (motion->path.state != GN_PATH_IDLE) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_REFUSED, "a path is running: set zones before it begins");
        return;
    }
    if (!gn_path_set_zone(&motion->path, zone)) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_INVALID,
                 "the zone's index or its half-spaces are out of range: at most 8 zones of 8 half-spaces");
        return;
    }
    gn_reply(motion, request_id, gonio_ReplyCode_REPLY_OK, "");
}
