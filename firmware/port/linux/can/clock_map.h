/* clock_map.h: socket stamps (CLOCK_REALTIME, which can step) to controller time (CLOCK_MONOTONIC), by pairs of both
 * clocks read together. Between steps of the wall clock their difference is constant, also under NTP. */
#ifndef GONIO_CLOCK_MAP_H
#define GONIO_CLOCK_MAP_H

#include <stdbool.h>
#include <stdint.h>

/* A difference that moves by less is taken over without being called a step: below every stamp's own uncertainty. */
#define GN_CLOCK_STEP_NS 1000
/* A frame may be stamped by the interrupt this long before it reaches the socket: soft interrupts are threads, and
 * share a loaded processor. */
#define GN_CLOCK_TRANSIT_NS 20000000

/* Both clocks, read in this order. */
struct gn_clock_pair {
    int64_t before_ns; /* monotonic */
    int64_t real_ns;
    int64_t after_ns; /* monotonic */
};

/* real - monotonic lies within [low, high]. */
struct gn_clock_offset {
    int64_t low_ns;
    int64_t high_ns;
};

struct gn_clock_map {
    struct gn_clock_offset present;
    struct gn_clock_offset previous; /* before the last step */
    bool stepped;                    /* since the socket was last found empty: frames of before may still come */
    int64_t empty_ns;                /* when it was */
    uint32_t steps;                  /* since start */
};

void gn_clock_map_init(struct gn_clock_map *map, const struct gn_clock_pair *pair);
/* With every look at the socket. */
void gn_clock_map_update(struct gn_clock_map *map, const struct gn_clock_pair *pair);
/* The socket was empty then: what comes later was stamped later. */
void gn_clock_map_drained(struct gn_clock_map *map, int64_t now_ns);
/* Controller time of a stamp read at now_ns. *by_arrival: the stamp could not be placed, this is now_ns. */
int64_t gn_clock_map_stamp(const struct gn_clock_map *map, int64_t real_ns, int64_t now_ns, bool *by_arrival);

#endif
