/* clock_fit.h: fits the line below a sliding window of strobe stamps. */
#ifndef GONIO_CLOCK_FIT_H
#define GONIO_CLOCK_FIT_H

#include "sample_clock.h"

/* The window's line: the edge of its lower convex hull over the middle. Least squares would be late by the mean
 * latency. */
struct gn_clock_fit gn_clock_fit_window(const struct gn_sample_clock *clock);

#endif
