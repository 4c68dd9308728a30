/* clock_fit.c: lower convex hull of the strobe stamps (Andrew's monotone chain) and the supporting line over the
 * middle. */
#include "clock_fit.h"

#include <math.h>

/* No crystal is further off; ordinary ones are within 100 ppm. */
#define CRYSTAL_TOLERANCE 1e-3

/* A strobe as the line sees it, relative to the window's oldest: doubles hold these differences exactly. */
struct place {
    double strobe;
    double late_ns; /* behind the nominal period */
};

static struct gn_clock_point point_at(const struct gn_sample_clock *clock, uint32_t index) {
    return clock->points[(clock->first + index) % GN_CLOCK_POINTS];
}

static struct place place_at(const struct gn_sample_clock *clock, uint32_t index) {
    struct gn_clock_point const oldest = point_at(clock, 0);
    struct gn_clock_point const point = point_at(clock, index);
    int64_t const strobe = point.strobe - oldest.strobe;
    int64_t const nominal_ns = strobe * clock->settings.sample_period_ns * (int64_t)clock->settings.samples_per_strobe;
    return (struct place){(double)strobe, (double)(point.stamp_ns - oldest.stamp_ns - nominal_ns)};
}

/* Twice the signed area of the triangle: positive where the way from a over b to c turns left. */
static double turn(struct place a, struct place b, struct place c) {
    return (b.strobe - a.strobe) * (c.late_ns - a.late_ns) - (b.late_ns - a.late_ns) * (c.strobe - a.strobe);
}

static double slope_between(struct place a, struct place b) {
    return (b.late_ns - a.late_ns) / (b.strobe - a.strobe);
}

/* Of the hull's edge over the middle. */
static double middle_slope(const struct place *hull, uint32_t corners) {
    double const middle = hull[corners - 1u].strobe / 2.0;
    uint32_t right = 1;
    while (right + 1u < corners && hull[right].strobe < middle) {
        ++right;
    }
    return slope_between(hull[right - 1u], hull[right]);
}

/* Stamps that come in heaps can pretend any period; a crystal's is near the nominal one. */
static double crystal_slope(const struct gn_sample_clock *clock, double slope) {
    double const nominal_ns = (double)(clock->settings.sample_period_ns * (int64_t)clock->settings.samples_per_strobe);
    return fmin(fmax(slope, -CRYSTAL_TOLERANCE * nominal_ns), CRYSTAL_TOLERANCE * nominal_ns);
}

struct gn_clock_fit gn_clock_fit_window(const struct gn_sample_clock *clock) {
    struct gn_clock_fit fit = {.nominal_period_ns = clock->settings.sample_period_ns};
    if (clock->count < 2u) {
        return fit;
    }
    struct place hull[GN_CLOCK_POINTS];
    uint32_t source[GN_CLOCK_POINTS];
    uint32_t corners = 0;
    for (uint32_t i = 0; i < clock->count; ++i) {
        struct place const next = place_at(clock, i);
        while (corners >= 2u && turn(hull[corners - 2u], hull[corners - 1u], next) <= 0.0) {
            --corners;
        }
        hull[corners] = next;
        source[corners++] = i;
    }
    /* The supporting line of that slope touches the corner where the edges become steeper. */
    double const slope = crystal_slope(clock, middle_slope(hull, corners));
    uint32_t touch = 0;
    while (touch + 1u < corners && slope_between(hull[touch], hull[touch + 1u]) < slope) {
        ++touch;
    }
    struct place const a = hull[touch];
    double sum_ns = 0.0;
    for (uint32_t i = 0; i < clock->count; ++i) {
        struct place const place = place_at(clock, i);
        sum_ns += place.late_ns - (a.late_ns + slope * (place.strobe - a.strobe));
    }
    struct gn_clock_point const support = point_at(clock, source[touch]);
    fit.reference_sample = support.strobe * (int64_t)clock->settings.samples_per_strobe;
    fit.reference_ns = support.stamp_ns;
    fit.excess_period_ns = slope / clock->settings.samples_per_strobe;
    fit.residual_ns = sum_ns / clock->count;
    fit.window = clock->count;
    return fit;
}

int64_t gn_clock_time_ns(const struct gn_clock_fit *fit, int64_t sample) {
    int64_t const ahead = sample - fit->reference_sample;
    return fit->reference_ns + ahead * fit->nominal_period_ns + llround((double)ahead * fit->excess_period_ns);
}

double gn_clock_period_ns(const struct gn_clock_fit *fit) {
    return (double)fit->nominal_period_ns + fit->excess_period_ns;
}
