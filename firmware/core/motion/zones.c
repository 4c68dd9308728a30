/* zones.c: a segment is clear of a convex zone if each of its pieces lies wholly outside one of the zone's half-spaces.
 */
#include "zones.h"

#include <math.h>
#include <string.h>

/* 2^-16 of a segment: at 30 degrees/s and 100 ms less than 0.0001 degree, far under the clearance of any holder. */
#define DEEPEST 16u

/* One piece of the segment: per half-space the Bernstein coefficients of a.q - b, positive outside. */
struct piece {
    double outside[GN_ZONE_HALF_SPACES][6];
    uint32_t depth;
};

enum verdict { CLEAR, ENTERED, UNDECIDED };

static double projection(const struct gn_zone *zone, uint32_t half_space, const double *position) {
    double sum = 0.0;
    for (uint32_t axis = 0; axis < GN_ZONE_AXES; axis++) {
        sum += zone->a[half_space][axis] * position[axis];
    }
    return sum;
}

bool gn_zone_contains(const struct gn_zone *zone, const double *position_counts) {
    for (uint32_t i = 0; i < zone->half_spaces; i++) {
        if (projection(zone, i, position_counts) > zone->b[i]) {
            return false;
        }
    }
    return zone->half_spaces > 0;
}

void gn_zone_for_path(struct gn_zone *zone, const gonio_Zone *configured, const double *start_counts) {
    memset(zone, 0, sizeof *zone);
    zone->half_spaces = configured->half_spaces_count;
    for (uint32_t i = 0; i < zone->half_spaces; i++) {
        memcpy(zone->a[i], configured->half_spaces[i].a, configured->half_spaces[i].a_count * sizeof(double));
        zone->b[i] = configured->half_spaces[i].b;
    }
    if (!gn_zone_contains(zone, start_counts)) {
        return;
    }
    for (uint32_t i = 0; i < zone->half_spaces; i++) {
        double one_count = 0.0; /* the drives stand still to a count */
        for (uint32_t axis = 0; axis < GN_ZONE_AXES; axis++) {
            one_count += fabs(zone->a[i][axis]);
        }
        zone->b[i] = projection(zone, i, start_counts) - one_count;
    }
}

static enum verdict judge(const struct piece *piece, uint32_t half_spaces) {
    bool start_inside = true;
    bool end_inside = true;
    for (uint32_t i = 0; i < half_spaces; i++) {
        if (gn_bernstein_hull(piece->outside[i], 5u).low > 0.0) {
            return CLEAR;
        }
        start_inside = start_inside && piece->outside[i][0] <= 0.0;
        end_inside = end_inside && piece->outside[i][5] <= 0.0;
    }
    return start_inside || end_inside ? ENTERED : UNDECIDED;
}

static void project(struct piece *piece, const struct gn_zone *zone, const struct gn_quintic *axes) {
    for (uint32_t point = 0; point < 6u; point++) {
        double position[GN_ZONE_AXES];
        for (uint32_t axis = 0; axis < GN_ZONE_AXES; axis++) {
            position[axis] = axes[axis].position[point];
        }
        for (uint32_t i = 0; i < zone->half_spaces; i++) {
            piece->outside[i][point] = projection(zone, i, position) - zone->b[i];
        }
    }
}

bool gn_zone_is_clear(const struct gn_zone *zone, const struct gn_quintic *axes) {
    struct piece stack[DEEPEST + 2u];
    if (zone->half_spaces == 0) {
        return true;
    }
    uint32_t waiting = 1;
    project(&stack[0], zone, axes);
    stack[0].depth = 0;
    while (waiting > 0) {
        struct piece const piece = stack[--waiting];
        enum verdict const verdict = judge(&piece, zone->half_spaces);
        if (verdict == CLEAR) {
            continue;
        }
        if (verdict == ENTERED || piece.depth == DEEPEST) {
            return false;
        }
        struct piece *left = &stack[waiting];
        struct piece *right = &stack[waiting + 1u];
        for (uint32_t i = 0; i < zone->half_spaces; i++) {
            gn_bernstein_split(piece.outside[i], 5u, left->outside[i], right->outside[i]);
        }
        left->depth = piece.depth + 1u;
        right->depth = piece.depth + 1u;
        waiting += 2u;
    }
    return true;
}
