/* path.c: the buffer of knots and the motion along them. */
#include "path.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "check.h"
#include "feed.h"

static struct gn_knot *knot_at(struct gn_path *path, uint32_t number) {
    return &path->knots[number % GN_PATH_CAPACITY];
}

void gn_path_init(struct gn_path *path) {
    memset(path, 0, sizeof *path);
}

void gn_path_set_limits(struct gn_path *path, uint32_t axis, const struct gn_axis_limits *limits) {
    path->limits[axis] = *limits;
}

bool gn_path_set_zone(struct gn_path *path, const gonio_Zone *zone) {
    if (zone->index >= GN_PATH_ZONES || zone->half_spaces_count == 0 || zone->half_spaces_count > GN_ZONE_HALF_SPACES) {
        return false;
    }
    for (uint32_t i = 0; i < zone->half_spaces_count; i++) {
        if (zone->half_spaces[i].a_count > GN_PATH_AXES || !isfinite(zone->half_spaces[i].b)) {
            return false;
        }
    }
    path->zones[zone->index] = *zone;
    return true;
}

bool gn_path_begin(struct gn_path *path, uint32_t path_id, uint32_t knot_count, char *why, uint32_t why_size) {
    bool const busy =
        path->state == GN_PATH_BUFFERING || path->state == GN_PATH_RUNNING || path->state == GN_PATH_HOLDING;
    if (busy) {
        snprintf(why, why_size, "path %" PRIu32 " cannot begin: path %" PRIu32 " is not over", path_id, path->path_id);
        return false;
    }
    if (knot_count < 2u) {
        snprintf(why, why_size, "path %" PRIu32 " has %" PRIu32 " knots, the least is 2", path_id, knot_count);
        return false;
    }
    gn_path_drop(path);
    path->path_id = path_id;
    path->knot_count = knot_count;
    path->state = GN_PATH_BUFFERING;
    return true;
}

static bool take_first(struct gn_path *path, const struct gn_knot *knot, const double *standing_counts, char *why,
                       uint32_t why_size) {
    if (!gn_check_start(knot, standing_counts, why, why_size)) {
        return false;
    }
    memcpy(path->start_counts, knot->position_counts, sizeof path->start_counts);
    for (uint32_t zone = 0; zone < GN_PATH_ZONES; zone++) {
        gn_zone_for_path(&path->clear_of[zone], &path->zones[zone], path->start_counts);
    }
    return true;
}

static bool is_acceptable(struct gn_path *path, uint32_t number, const struct gn_knot *knot,
                          const double *standing_counts, char *why, uint32_t why_size) {
    if (number != path->received) {
        snprintf(why, why_size, "knot %" PRIu32 ": out of order, %" PRIu32 " was expected", number, path->received);
        return false;
    }
    if (number >= gn_path_credit(path)) {
        snprintf(why, why_size, "knot %" PRIu32 ": beyond the credit of %" PRIu32, number, gn_path_credit(path));
        return false;
    }
    if (!gn_check_knot(knot, number, path->knot_count, why, why_size)) {
        return false;
    }
    return number == 0 ? take_first(path, knot, standing_counts, why, why_size)
                       : gn_check_segment(path, knot_at(path, number - 1u), knot, number, why, why_size);
}

bool gn_path_push(struct gn_path *path, uint32_t number, const struct gn_knot *knot, const double *standing_counts,
                  char *why, uint32_t why_size) {
    bool const taking =
        path->state == GN_PATH_BUFFERING || path->state == GN_PATH_RUNNING || path->state == GN_PATH_HOLDING;
    if (!taking) {
        snprintf(why, why_size, "knot %" PRIu32 ": no path is under way", number);
        return false;
    }
    if (!is_acceptable(path, number, knot, standing_counts, why, why_size)) {
        if (path->state == GN_PATH_BUFFERING) {
            gn_path_drop(path);
        } else {
            path->state = GN_PATH_HOLDING;
        }
        return false;
    }
    *knot_at(path, number) = *knot;
    path->received++;
    return true;
}

uint32_t gn_path_credit(const struct gn_path *path) {
    uint32_t const room = path->used + GN_PATH_CAPACITY;
    return room < path->knot_count ? room : path->knot_count;
}

void gn_path_hold(struct gn_path *path) {
    if (path->state == GN_PATH_BUFFERING) {
        path->state = GN_PATH_HELD;
    } else if (path->state == GN_PATH_RUNNING) {
        path->state = GN_PATH_HOLDING;
    }
}

void gn_path_drop(struct gn_path *path) {
    path->state = GN_PATH_IDLE;
    path->knot_count = 0;
    path->received = 0;
    path->used = 0;
    path->feed = 0.0;
    path->time_ns = 0;
    path->time_fraction_ns = 0.0;
}

/* Path time from here to the last knot received. */
static double left_s(struct gn_path *path) {
    int64_t const last_ns = knot_at(path, path->received - 1u)->time_ns;
    return ((double)(last_ns - path->time_ns) - path->time_fraction_ns) * 1e-9;
}

static void start_if_ready(struct gn_path *path) {
    if (path->received < 2u) {
        return;
    }
    /* Knots so close that a full buffer is short of the stopping distance start at a lower feed. */
    bool const enough = path->received >= GN_PATH_CAPACITY / 2u && left_s(path) >= gn_feed_stopping_s(1.0);
    if (path->received == path->knot_count) {
        path->feed = 1.0; /* at rest: any feed is without a jump */
    } else if (enough || path->received == GN_PATH_CAPACITY) {
        path->feed = fmin(1.0, sqrt(2.0 * GN_PATH_HOLD_RATE_PER_S * left_s(path)));
    } else {
        return;
    }
    path->state = GN_PATH_RUNNING;
}

static void locate(struct gn_path *path, struct gn_state *axes) {
    while (path->used + 2u < path->received && knot_at(path, path->used + 1u)->time_ns <= path->time_ns) {
        path->used++;
    }
    struct gn_quintic segment[GN_PATH_AXES];
    const struct gn_knot *from = knot_at(path, path->used);
    gn_segment(segment, from, knot_at(path, path->used + 1u));
    double const time_s = ((double)(path->time_ns - from->time_ns) + path->time_fraction_ns) * 1e-9;
    for (uint32_t axis = 0; axis < GN_PATH_AXES; axis++) {
        axes[axis] = gn_quintic_state(&segment[axis], time_s);
    }
}

static void advance(struct gn_path *path, int64_t dt_ns, bool *underrun) {
    struct gn_state axes[GN_PATH_AXES];
    locate(path, axes);
    bool const complete = path->received == path->knot_count;
    bool const holding = path->state == GN_PATH_HOLDING;
    double const rate = gn_feed_rate_per_s(path->limits, axes, path->feed);
    double const left = complete ? HUGE_VAL : left_s(path);
    double const dt_s = (double)dt_ns * 1e-9;
    bool limited = false;
    double const next = gn_feed_next(path->feed, holding ? 0.0 : 1.0, rate, left, dt_s, &limited);
    *underrun = limited && !holding;

    double const moved_ns = path->time_fraction_ns + 0.5 * (path->feed + next) * (double)dt_ns;
    double const whole_ns = floor(moved_ns);
    path->time_ns += (int64_t)whole_ns;
    path->time_fraction_ns = moved_ns - whole_ns;
    path->feed = next;

    int64_t const last_ns = knot_at(path, path->received - 1u)->time_ns;
    if (path->time_ns >= last_ns) {
        path->time_ns = last_ns;
        path->time_fraction_ns = 0.0;
        path->feed = 0.0;
    }
    if (complete && path->time_ns == last_ns) {
        path->state = GN_PATH_DONE;
    } else if ((holding && path->feed <= 0.0) || (*underrun && path->feed < GN_PATH_HOLD_RATE_PER_S * dt_s)) {
        path->feed = 0.0;
        path->state = GN_PATH_HELD;
    }
}

void gn_path_step(struct gn_path *path, int64_t dt_ns, double *target_counts, bool *underrun) {
    *underrun = false;
    if (path->state == GN_PATH_BUFFERING) {
        start_if_ready(path);
    }
    if (path->state == GN_PATH_RUNNING || path->state == GN_PATH_HOLDING) {
        struct gn_state axes[GN_PATH_AXES];
        advance(path, dt_ns, underrun);
        locate(path, axes);
        for (uint32_t axis = 0; axis < GN_PATH_AXES; axis++) {
            target_counts[axis] = axes[axis].position;
        }
    }
}
