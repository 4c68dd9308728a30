/* bernstein.c: values, halving and bounds of polynomials in Bernstein form. */
#include "bernstein.h"

#include <math.h>
#include <string.h>

/* The hull's error falls fourfold with each halving: 30 halvings are past the resolution of a double. */
#define DEEPEST 30u
/* Of the largest coefficient: a finer tolerance would chase rounding. */
#define ROUNDING 1e-12

struct piece {
    double coefficients[GN_BERNSTEIN_COUNT];
    uint32_t depth;
};

void gn_bernstein_split(const double *coefficients, uint32_t degree, double *left, double *right) {
    double work[GN_BERNSTEIN_COUNT];
    memcpy(work, coefficients, (degree + 1u) * sizeof work[0]);
    for (uint32_t level = 0; level <= degree; level++) {
        left[level] = work[0];
        right[degree - level] = work[degree - level];
        for (uint32_t i = 0; i + level < degree; i++) {
            work[i] = 0.5 * (work[i] + work[i + 1u]);
        }
    }
}

double gn_bernstein_value(const double *coefficients, uint32_t degree, double u) {
    double work[GN_BERNSTEIN_COUNT];
    memcpy(work, coefficients, (degree + 1u) * sizeof work[0]);
    for (uint32_t level = degree; level > 0; level--) {
        for (uint32_t i = 0; i < level; i++) {
            work[i] = (1.0 - u) * work[i] + u * work[i + 1u];
        }
    }
    return work[0];
}

struct gn_range gn_bernstein_hull(const double *coefficients, uint32_t degree) {
    struct gn_range hull = {coefficients[0], coefficients[0]};
    for (uint32_t i = 1; i <= degree; i++) {
        hull.low = fmin(hull.low, coefficients[i]);
        hull.high = fmax(hull.high, coefficients[i]);
    }
    return hull;
}

struct gn_range gn_bernstein_bounds(const double *coefficients, uint32_t degree, double tolerance) {
    struct piece stack[DEEPEST + 2u];
    /* `reached` holds values on the curve, `bounds` the hulls of the pieces that need no further halving. */
    struct gn_range reached = {fmin(coefficients[0], coefficients[degree]),
                               fmax(coefficients[0], coefficients[degree])};
    struct gn_range bounds = reached;
    struct gn_range const whole = gn_bernstein_hull(coefficients, degree);
    double const enough = fmax(tolerance, ROUNDING * fmax(fabs(whole.low), fabs(whole.high)));
    uint32_t waiting = 1;
    memcpy(stack[0].coefficients, coefficients, (degree + 1u) * sizeof(double));
    stack[0].depth = 0;
    while (waiting > 0) {
        struct piece const piece = stack[--waiting];
        struct gn_range const hull = gn_bernstein_hull(piece.coefficients, degree);
        if (piece.depth == DEEPEST || (hull.low >= reached.low - enough && hull.high <= reached.high + enough)) {
            bounds.low = fmin(bounds.low, hull.low);
            bounds.high = fmax(bounds.high, hull.high);
            continue;
        }
        struct piece *left = &stack[waiting];
        struct piece *right = &stack[waiting + 1u];
        gn_bernstein_split(piece.coefficients, degree, left->coefficients, right->coefficients);
        left->depth = piece.depth + 1u;
        right->depth = piece.depth + 1u;
        reached.low = fmin(reached.low, right->coefficients[0]);
        reached.high = fmax(reached.high, right->coefficients[0]);
        waiting += 2u;
    }
    return bounds;
}
