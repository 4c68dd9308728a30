/* sample_clock.h: the time of sample k, from the strobe's rising edges: the line below all their stamps. */
#ifndef GONIO_SAMPLE_CLOCK_H
#define GONIO_SAMPLE_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "edge.h"

#define GN_CLOCK_POINTS 1024u                   /* strobes in the window at most */
#define GN_CLOCK_WINDOW_NS INT64_C(10000000000) /* longer: the crystal's drift bends the line */
#define GN_CLOCK_WIDE_PULSE_EVERY 64            /* strobes */

struct gn_clock_settings {
    int64_t sample_period_ns;
    uint32_t samples_per_strobe;
    int64_t settle_ns;
    uint32_t tolerance_percent; /* of a strobe period */
};

struct gn_clock_point {
    int64_t strobe; /* number since START */
    int64_t stamp_ns;
};

/* A line in (sample, time), kept as a point on it and the excess over the nominal period, so that no digit is lost. */
struct gn_clock_fit {
    int64_t reference_sample;
    int64_t reference_ns;
    int64_t nominal_period_ns;
    double excess_period_ns; /* fitted minus nominal sample period */
    double residual_ns;      /* mean of the stamps above the line */
    uint32_t window;         /* strobes in the fit; 0: none */
};

struct gn_sample_clock {
    struct gn_clock_settings settings;
    bool running;
    bool aligned;         /* a double-width pulse has confirmed the numbers */
    uint32_t last_number; /* of any edge of the line */
    bool numbered;        /* a first edge has come since START */
    struct gn_clock_point newest;
    struct gn_clock_point points[GN_CLOCK_POINTS];
    uint32_t first; /* place of the oldest point */
    uint32_t count;
    bool pulse_open;          /* the newest point's pulse has not ended yet */
    int64_t suspected_offset; /* strobes; what one double-width pulse says against the numbers, 0: nothing */
    uint32_t rejected_in_row;
    uint32_t rejected_since_newest;
    bool fit_is_current;
    struct gn_clock_fit fit;
    /* since the controller's start */
    uint64_t strobes;
    uint64_t strobes_lost; /* places where no edge came, not even a rejected one */
    uint64_t strobes_rejected;
    uint64_t strobe_realigned;
};

/* After START and before its first edge. The counts go on. */
void gn_sample_clock_start(struct gn_sample_clock *clock, const struct gn_clock_settings *settings);
void gn_sample_clock_stop(struct gn_sample_clock *clock);
/* Every edge of the strobe line, both directions, acquiring or not. */
void gn_sample_clock_edge(struct gn_sample_clock *clock, const struct gn_edge *edge);
/* true: enough strobes, aligned, and still coming. */
bool gn_sample_clock_settled(const struct gn_sample_clock *clock, int64_t now_ns);
/* true: strobes came, and have stayed away for twice as long as the clock may run on without them. */
bool gn_sample_clock_silent(const struct gn_sample_clock *clock, int64_t now_ns);
/* false: not settled, nothing stored. */
bool gn_sample_clock_fit(struct gn_sample_clock *clock, int64_t now_ns, struct gn_clock_fit *fit);
/* Controller time of a sample by a fit with a window. */
int64_t gn_clock_time_ns(const struct gn_clock_fit *fit, int64_t sample);
double gn_clock_period_ns(const struct gn_clock_fit *fit);

#endif
