/* feed.c: the law of the feed. */
#include "feed.h"

#include <math.h>

/* The room that the acceleration limit leaves is taken at one point of a cycle: keep some for the cycle's other end. */
#define ROOM_USED 0.9
/* Faster changes would gain no time and only shake the arm. */
#define FASTEST_PER_S 5.0

double gn_feed_stopping_s(double feed) {
    return feed * feed / (2.0 * GN_PATH_HOLD_RATE_PER_S);
}

double gn_feed_rate_per_s(const struct gn_axis_limits *limits, const struct gn_state *axes, double feed) {
    double rate = FASTEST_PER_S;
    for (uint32_t axis = 0; axis < GN_PATH_AXES; axis++) {
        double const room =
            ROOM_USED * (limits[axis].max_acceleration_counts_per_s2 - feed * feed * fabs(axes[axis].acceleration));
        double const speed = fabs(axes[axis].velocity);
        if (speed * rate > room) {
            rate = room / speed;
        }
    }
    return fmax(rate, GN_PATH_HOLD_RATE_PER_S);
}

double gn_feed_next(double feed, double wanted, double rate_per_s, double left_s, double dt_s, bool *limited) {
    double const step = rate_per_s * dt_s;
    double next = fmin(fmax(wanted, feed - step), feed + step);
    *limited = false;
    if (gn_feed_stopping_s(next) > left_s - 0.5 * (feed + next) * dt_s) {
        /* Largest feed whose stopping distance is what will be left: next^2 + d dt next + d dt feed - 2 d left = 0. */
        double const half = 0.5 * GN_PATH_HOLD_RATE_PER_S * dt_s;
        double const square = half * half + 2.0 * GN_PATH_HOLD_RATE_PER_S * left_s - 2.0 * half * feed;
        next = fmin(next, fmax(0.0, sqrt(fmax(0.0, square)) - half));
        *limited = true;
    }
    return next;
}
