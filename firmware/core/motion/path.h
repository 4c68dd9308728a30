/* path.h: buffered quintic knots, the checks on receipt, and motion along them with feed hold (path time is scaled). */
#ifndef GONIO_PATH_H
#define GONIO_PATH_H

#include <stdbool.h>
#include <stdint.h>

#include "gonio.pb.h"
#include "gonio_records.h"
#include "zones.h"

#define GN_PATH_AXES 4u
#define GN_PATH_CAPACITY 256u /* knots held */
#define GN_PATH_ZONES 8u
/* Every accepted segment leaves this much of the acceleration limits to the feed: |q''| + rate |q'| <= limit. A feed
 * hold is thus within the limits everywhere on the path, and ends after 1 / (2 rate) of path time at the latest. */
#define GN_PATH_HOLD_RATE_PER_S 0.5
/* From full feed a hold is thus over after this long at the latest. */
#define GN_PATH_HOLD_MS ((uint32_t)(1000.0 / GN_PATH_HOLD_RATE_PER_S))
/* Knot 0 may be this far from where the axes stand: the noise of an encoder at rest, 0.02 degrees. */
#define GN_PATH_START_TOLERANCE_COUNTS 20.0

struct gn_axis_limits {
    double min_counts, max_counts;
    double max_velocity_counts_per_s;
    double max_acceleration_counts_per_s2;
    const char *velocity_reason; /* why it is lower than the instrument's, and the cure; NULL: it is not */
};

enum gn_path_state {
    GN_PATH_IDLE = 0,
    GN_PATH_BUFFERING = 1, /* begun, waits for the stopping distance (or all knots) to be buffered */
    GN_PATH_RUNNING = 2,
    GN_PATH_HOLDING = 3, /* feed goes to zero on the path */
    GN_PATH_DONE = 4,    /* last knot reached */
    GN_PATH_HELD = 5,    /* stopped on the path; the rest was discarded */
};

struct gn_path {
    struct gn_axis_limits limits[GN_PATH_AXES];
    gonio_Zone zones[GN_PATH_ZONES];
    struct gn_knot knots[GN_PATH_CAPACITY];
    uint32_t path_id;
    uint32_t knot_count; /* announced */
    uint32_t received;   /* accepted so far */
    uint32_t used;       /* knots left behind */
    enum gn_path_state state;
    double feed;     /* path time per time, 0..1 */
    int64_t time_ns; /* path time */
    double time_fraction_ns;
    double start_counts[GN_PATH_AXES];      /* knot 0 */
    struct gn_zone clear_of[GN_PATH_ZONES]; /* the zones as this path must keep clear of them */
};

void gn_path_init(struct gn_path *path);
void gn_path_set_limits(struct gn_path *path, uint32_t axis, const struct gn_axis_limits *limits);
/* false: index or half-spaces out of range. */
bool gn_path_set_zone(struct gn_path *path, const gonio_Zone *zone);

/* Begin a path of at least two knots. false: one is running; `why` gets the sentence. */
bool gn_path_begin(struct gn_path *path, uint32_t path_id, uint32_t knot_count, char *why, uint32_t why_size);
/* Take the next knot: its number, its time, the segment's position, velocity, acceleration and zones are checked first.
 * The first knot must be at rest, at time 0 and within the start tolerance of `standing_counts`; the last at rest.
 * Knots of a holding path are still taken: they were on their way when it began to hold. false: refused, the path holds
 * (feed hold) or is dropped if it did not run yet, and `why` names axis, knot and limit. */
bool gn_path_push(struct gn_path *path, uint32_t number, const struct gn_knot *knot, const double *standing_counts,
                  char *why, uint32_t why_size);
/* How many knots of this path the host may have sent in all. */
uint32_t gn_path_credit(const struct gn_path *path);
/* Advance by dt_ns of real time and give the target of each axis. The path starts by itself when enough is buffered:
 * all knots, or at least the stopping distance and half the buffer. Targets are written while it runs, not before or
 * after. If the buffer gets shorter than the stopping distance before the last knot, the feed goes down by itself
 * (underrun never runs off the end); *underrun says so. It rises again when knots come; once at rest the path is HELD.
 */
void gn_path_step(struct gn_path *path, int64_t dt_ns, double *target_counts, bool *underrun);
/* Controlled stop on the path; no effect when idle. */
void gn_path_hold(struct gn_path *path);
/* Forget the path (after a fault, or once DONE/HELD was seen). */
void gn_path_drop(struct gn_path *path);

#endif
