/* feed.h: how fast path time runs: full feed, feed hold, and never faster than the buffered path allows to stop. */
#ifndef GONIO_FEED_H
#define GONIO_FEED_H

#include <stdbool.h>

#include "path.h"
#include "quintic.h"

/* Path time needed to stop from `feed` at the guaranteed rate, s. */
double gn_feed_stopping_s(double feed);
/* The rate of change of the feed that leaves every axis within its acceleration limit at this point of the path, per s:
 * with q(s) and ds/dt = f the acceleration is f^2 q'' + f' q'. Never under GN_PATH_HOLD_RATE_PER_S, which the checks on
 * receipt have made possible everywhere. */
double gn_feed_rate_per_s(const struct gn_axis_limits *limits, const struct gn_state *axes, double feed);
/* The feed after dt_s: towards `wanted`, at most by the rate, and such that after the step the remaining buffered path
 * (`left_s` now) still holds the stopping distance. *limited: the buffer kept it lower. */
double gn_feed_next(double feed, double wanted, double rate_per_s, double left_s, double dt_s, bool *limited);

#endif
