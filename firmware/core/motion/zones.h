/* zones.h: convex regions of axis space that no path may enter. */
#ifndef GONIO_ZONES_H
#define GONIO_ZONES_H

#include <stdbool.h>

#include "gonio.pb.h"
#include "quintic.h"

#define GN_ZONE_HALF_SPACES 8u
#define GN_ZONE_AXES 4u

/* A zone for one path. A path that starts inside may leave: the zone shrinks to what lies deeper than the start. */
struct gn_zone {
    uint32_t half_spaces; /* 0: no zone */
    double a[GN_ZONE_HALF_SPACES][GN_ZONE_AXES];
    double b[GN_ZONE_HALF_SPACES]; /* inside where every a.q <= b */
};

/* The zone as a path from `start_counts` must keep clear of it. */
void gn_zone_for_path(struct gn_zone *zone, const gonio_Zone *configured, const double *start_counts);
bool gn_zone_contains(const struct gn_zone *zone, const double *position_counts);
/* Whether the segment (one quintic per axis) certainly keeps out; one that cannot be told apart from a touch does not.
 */
bool gn_zone_is_clear(const struct gn_zone *zone, const struct gn_quintic *axes);

#endif
