/* check.c: the checks of knots and segments. */
#include "check.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Closer knots would only cost buffer; the sums of a segment stay well conditioned. */
#define SHORTEST_NS 1000000
/* Rounding of the host's and of our own sums: relative for speeds, half a count for positions. */
#define SLACK 1e-6
#define POSITION_SLACK_COUNTS 0.5
/* What counts as rest, counts/s and counts/s2. */
#define REST 1e-6
/* No axis has such positions (counts), speeds or accelerations; below it every sum of a segment is finite. */
#define LARGEST 1e12

void gn_segment(struct gn_quintic *axes, const struct gn_knot *from, const struct gn_knot *to) {
    double const duration_s = (double)(to->time_ns - from->time_ns) * 1e-9;
    for (uint32_t axis = 0; axis < GN_PATH_AXES; axis++) {
        struct gn_state const start = {from->position_counts[axis], from->velocity_counts_per_s[axis],
                                       from->acceleration_counts_per_s2[axis]};
        struct gn_state const end = {to->position_counts[axis], to->velocity_counts_per_s[axis],
                                     to->acceleration_counts_per_s2[axis]};
        axes[axis] = gn_quintic_join(&start, &end, duration_s);
    }
}

bool gn_check_knot(const struct gn_knot *knot, uint32_t number, uint32_t knot_count, char *why, uint32_t why_size) {
    bool const end = number == 0 || number + 1u == knot_count;
    for (uint32_t axis = 0; axis < GN_PATH_AXES; axis++) {
        double const velocity = knot->velocity_counts_per_s[axis];
        double const acceleration = knot->acceleration_counts_per_s2[axis];
        /* Written so that a NaN fails. */
        bool const usable =
            fabs(knot->position_counts[axis]) < LARGEST && fabs(velocity) < LARGEST && fabs(acceleration) < LARGEST;
        if (!usable) {
            snprintf(why, why_size, "axis %" PRIu32 ", knot %" PRIu32 ": a value is no number or beyond all limits",
                     axis + 1u, number);
            return false;
        }
        if (end && (fabs(velocity) > REST || fabs(acceleration) > REST)) {
            snprintf(why, why_size,
                     "axis %" PRIu32 ", knot %" PRIu32 ": a path begins and ends at rest, not at %.0f counts/s and "
                     "%.0f counts/s2",
                     axis + 1u, number, velocity, acceleration);
            return false;
        }
    }
    return true;
}

bool gn_check_start(const struct gn_knot *knot, const double *standing_counts, char *why, uint32_t why_size) {
    if (knot->time_ns != 0) {
        snprintf(why, why_size, "knot 0: its time must be 0, not %" PRId64 " ns", knot->time_ns);
        return false;
    }
    for (uint32_t axis = 0; axis < GN_PATH_AXES; axis++) {
        if (!(fabs(knot->position_counts[axis] - standing_counts[axis]) <= GN_PATH_START_TOLERANCE_COUNTS)) {
            snprintf(why, why_size, "axis %" PRIu32 ", knot 0: starts at %.0f counts, the axis stands at %.0f",
                     axis + 1u, knot->position_counts[axis], standing_counts[axis]);
            return false;
        }
    }
    return true;
}

/* The bounds of a polynomial in Bernstein form, refined only where the plain hull passes the limits. */
static struct gn_range bounds_near(const double *coefficients, uint32_t degree, double low, double high,
                                   double tolerance) {
    struct gn_range const hull = gn_bernstein_hull(coefficients, degree);
    return hull.low >= low && hull.high <= high ? hull : gn_bernstein_bounds(coefficients, degree, tolerance);
}

static bool refuse_range(const char *what, const char *unit, uint32_t axis, uint32_t number, struct gn_range range,
                         struct gn_range limit, char *why, uint32_t why_size) {
    bool const over = range.high > limit.high;
    snprintf(why, why_size, "axis %" PRIu32 ", knot %" PRIu32 ": %s %.0f %s is %s the limit of %.0f", axis + 1u, number,
             what, over ? range.high : range.low, unit, over ? "over" : "under", over ? limit.high : limit.low);
    return false;
}

static bool check_position(const struct gn_path *path, uint32_t axis, const struct gn_quintic *segment, uint32_t number,
                           char *why, uint32_t why_size) {
    /* An axis that stands outside its limits, as after homing on a switch, may come back but not go farther. */
    struct gn_range const limit = {fmin(path->limits[axis].min_counts, path->start_counts[axis]),
                                   fmax(path->limits[axis].max_counts, path->start_counts[axis])};
    double const low = limit.low - POSITION_SLACK_COUNTS;
    double const high = limit.high + POSITION_SLACK_COUNTS;
    struct gn_range const range = bounds_near(segment->position, 5u, low, high, 0.1 * POSITION_SLACK_COUNTS);
    return (range.low >= low && range.high <= high) ||
           refuse_range("position", "counts", axis, number, range, limit, why, why_size);
}

static bool check_magnitude(const char *what, const char *unit, const double *coefficients, double limit, uint32_t axis,
                            uint32_t number, char *why, uint32_t why_size) {
    double const high = limit * (1.0 + SLACK) + REST;
    struct gn_range const range = bounds_near(coefficients, 4u, -high, high, 0.1 * SLACK * limit + REST);
    return (range.low >= -high && range.high <= high) ||
           refuse_range(what, unit, axis, number, range, (struct gn_range){-limit, limit}, why, why_size);
}

static bool check_velocity(const struct gn_axis_limits *limits, const double *velocity, uint32_t axis, uint32_t number,
                           char *why, uint32_t why_size) {
    if (check_magnitude("velocity", "counts/s", velocity, limits->max_velocity_counts_per_s, axis, number, why,
                        why_size)) {
        return true;
    }
    if (limits->velocity_reason != NULL) {
        size_t const used = strlen(why);
        snprintf(why + used, why_size - used, ": %s", limits->velocity_reason);
    }
    return false;
}

/* q'' + rate q' in Bernstein form: the acceleration with the feed rising or falling at the guaranteed rate. */
static void with_feed_change(const double *velocity, const double *acceleration, double rate_per_s, double *sum) {
    for (uint32_t i = 0; i <= 4u; i++) {
        double const part = (double)i / 4.0;
        double const before = i > 0 ? part * acceleration[i - 1u] : 0.0;
        double const after = i < 4u ? (1.0 - part) * acceleration[i] : 0.0;
        sum[i] = before + after + rate_per_s * velocity[i];
    }
}

static bool check_axis(const struct gn_path *path, uint32_t axis, const struct gn_quintic *segment, uint32_t number,
                       char *why, uint32_t why_size) {
    const struct gn_axis_limits *limits = &path->limits[axis];
    double velocity[5];
    double acceleration[4];
    double rising[5];
    double falling[5];
    gn_quintic_velocity(segment, velocity);
    gn_quintic_acceleration(segment, acceleration);
    with_feed_change(velocity, acceleration, GN_PATH_HOLD_RATE_PER_S, rising);
    with_feed_change(velocity, acceleration, -GN_PATH_HOLD_RATE_PER_S, falling);
    const char *const sum = "acceleration with the feed hold's share";
    return check_position(path, axis, segment, number, why, why_size) &&
           check_velocity(limits, velocity, axis, number, why, why_size) &&
           check_magnitude(sum, "counts/s2", rising, limits->max_acceleration_counts_per_s2, axis, number, why,
                           why_size) &&
           check_magnitude(sum, "counts/s2", falling, limits->max_acceleration_counts_per_s2, axis, number, why,
                           why_size);
}

bool gn_check_segment(const struct gn_path *path, const struct gn_knot *from, const struct gn_knot *to, uint32_t number,
                      char *why, uint32_t why_size) {
    struct gn_quintic axes[GN_PATH_AXES];
    if (to->time_ns < from->time_ns || to->time_ns - from->time_ns < SHORTEST_NS) {
        snprintf(why, why_size, "knot %" PRIu32 ": comes %" PRId64 " ns after knot %" PRIu32 ", the least is %d ns",
                 number, to->time_ns < from->time_ns ? 0 : to->time_ns - from->time_ns, number - 1u, SHORTEST_NS);
        return false;
    }
    gn_segment(axes, from, to);
    for (uint32_t axis = 0; axis < GN_PATH_AXES; axis++) {
        if (!check_axis(path, axis, &axes[axis], number, why, why_size)) {
            return false;
        }
    }
    for (uint32_t zone = 0; zone < GN_PATH_ZONES; zone++) {
        if (!gn_zone_is_clear(&path->clear_of[zone], axes)) {
            snprintf(why, why_size, "knot %" PRIu32 ": on the way there the arm would enter \"%s\"", number,
                     path->zones[zone].name);
            return false;
        }
    }
    return true;
}
