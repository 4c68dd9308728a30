/* sample_clock.c: numbers the strobe edges by their time, rejects those out of place, and keeps the numbers aligned by
 * width. */
#include "sample_clock.h"

#include <math.h>
#include <string.h>

#include "clock_fit.h"

/* So many rejected in a row: it is the line that is wrong. */
#define REJECTED_BEFORE_RESTART 16u
/* Strobes in the fit before an early edge can be told from a line that still sinks. */
#define EARLY_CHECK_WINDOW 64u
/* Room for the crystal to bend the line. */
#define EARLY_FLOOR_NS 5000.0
/* The line is above the truth by about residual / window, and by several times that at its newest end. */
#define EARLY_RESIDUALS 32.0
/* The line that edges are judged by is made anew every so many strobes. */
#define REFRESH_EVERY 16
/* Strobes; a greater jump of the numbers is not a loss but another numbering. */
#define LOST_AT_START_MAX 4096u

void gn_sample_clock_start(struct gn_sample_clock *clock, const struct gn_clock_settings *settings) {
    clock->settings = *settings;
    clock->running = true;
    clock->aligned = false;
    clock->numbered = false;
    clock->first = 0;
    clock->count = 0;
    clock->pulse_open = false;
    clock->suspected_offset = 0;
    clock->rejected_in_row = 0;
    clock->rejected_since_newest = 0;
    clock->fit_is_current = false;
    memset(&clock->fit, 0, sizeof clock->fit);
}

void gn_sample_clock_stop(struct gn_sample_clock *clock) {
    clock->running = false;
    clock->count = 0;
}

static int64_t strobe_period_ns(const struct gn_sample_clock *clock) {
    return clock->settings.sample_period_ns * (int64_t)clock->settings.samples_per_strobe;
}

static void refresh_fit(struct gn_sample_clock *clock) {
    if (!clock->fit_is_current) {
        clock->fit = gn_clock_fit_window(clock);
        clock->fit_is_current = true;
    }
}

/* By the last fit, or from the newest edge as long as there is none. */
static int64_t predicted_ns(const struct gn_sample_clock *clock, int64_t strobe) {
    if (clock->fit.window > 0u) {
        return gn_clock_time_ns(&clock->fit, strobe * (int64_t)clock->settings.samples_per_strobe);
    }
    return clock->newest.stamp_ns + (strobe - clock->newest.strobe) * strobe_period_ns(clock);
}

static int64_t nearest_strobe(const struct gn_sample_clock *clock, int64_t stamp_ns) {
    double period_ns = (double)strobe_period_ns(clock);
    if (clock->fit.window > 0u) {
        period_ns = gn_clock_period_ns(&clock->fit) * clock->settings.samples_per_strobe;
    }
    int64_t const after_newest_ns = stamp_ns - predicted_ns(clock, clock->newest.strobe);
    return clock->newest.strobe + llround((double)after_newest_ns / period_ns);
}

static bool in_place(const struct gn_sample_clock *clock, int64_t strobe, int64_t stamp_ns) {
    if (strobe <= clock->newest.strobe) {
        return false; /* that place is taken */
    }
    int64_t const late_ns = stamp_ns - predicted_ns(clock, strobe);
    int64_t const tolerance_ns = strobe_period_ns(clock) * (int64_t)clock->settings.tolerance_percent / 100;
    if (late_ns > tolerance_ns || late_ns < -tolerance_ns) {
        return false;
    }
    /* Stamps are late, never early: one far below the line is no strobe, and would pull the whole line down. */
    const struct gn_clock_fit *fit = &clock->fit;
    return fit->window < EARLY_CHECK_WINDOW ||
           (double)late_ns > -(EARLY_FLOOR_NS + EARLY_RESIDUALS * fit->residual_ns / fit->window);
}

static void shorten_window(struct gn_sample_clock *clock) {
    while (clock->count > 0u && (clock->count == GN_CLOCK_POINTS ||
                                 clock->newest.stamp_ns - clock->points[clock->first].stamp_ns > GN_CLOCK_WINDOW_NS)) {
        clock->first = (clock->first + 1u) % GN_CLOCK_POINTS;
        --clock->count;
    }
}

static void accept(struct gn_sample_clock *clock, int64_t strobe, int64_t stamp_ns) {
    clock->newest = (struct gn_clock_point){strobe, stamp_ns};
    shorten_window(clock);
    clock->points[(clock->first + clock->count) % GN_CLOCK_POINTS] = clock->newest;
    ++clock->count;
    ++clock->strobes;
    clock->rejected_in_row = 0;
    clock->rejected_since_newest = 0;
    clock->fit_is_current = false;
    clock->pulse_open = true;
}

/* The first edge after START: strobe 0, unless the kernel's numbers say that edges before it were lost. */
static void first_edge(struct gn_sample_clock *clock, const struct gn_edge *edge) {
    uint32_t const lost_edges = edge->number - clock->last_number - 1u;
    uint32_t const lost = lost_edges / 2u <= LOST_AT_START_MAX ? lost_edges / 2u : 0u;
    clock->numbered = true;
    clock->strobes_lost += lost;
    accept(clock, lost, edge->stamp_ns);
}

static void reject(struct gn_sample_clock *clock, int64_t strobe, int64_t stamp_ns) {
    ++clock->strobes_rejected;
    ++clock->rejected_since_newest;
    if (++clock->rejected_in_row < REJECTED_BEFORE_RESTART) {
        return;
    }
    clock->count = 0;
    clock->aligned = false;
    memset(&clock->fit, 0, sizeof clock->fit);
    accept(clock, strobe > clock->newest.strobe ? strobe : clock->newest.strobe + 1, stamp_ns);
}

static void rising(struct gn_sample_clock *clock, const struct gn_edge *edge) {
    clock->pulse_open = false;
    if (!clock->numbered) {
        first_edge(clock, edge);
        return;
    }
    /* With few strobes the line still moves; later a slightly older one is good enough to predict by. */
    if (clock->count < EARLY_CHECK_WINDOW || clock->newest.strobe % REFRESH_EVERY == 0) {
        refresh_fit(clock);
    }
    int64_t const strobe = nearest_strobe(clock, edge->stamp_ns);
    if (!in_place(clock, strobe, edge->stamp_ns)) {
        reject(clock, strobe, edge->stamp_ns);
        return;
    }
    uint64_t const empty = (uint64_t)(strobe - clock->newest.strobe - 1);
    clock->strobes_lost += empty > clock->rejected_since_newest ? empty - clock->rejected_since_newest : 0u;
    accept(clock, strobe, edge->stamp_ns);
}

static void realign(struct gn_sample_clock *clock, int64_t offset) {
    for (uint32_t i = 0; i < clock->count; ++i) {
        clock->points[(clock->first + i) % GN_CLOCK_POINTS].strobe += offset;
    }
    clock->newest.strobe += offset;
    clock->strobes_lost += offset > 0 && !clock->aligned ? (uint64_t)offset : 0u;
    ++clock->strobe_realigned;
    clock->suspected_offset = 0;
    clock->aligned = true;
    clock->fit_is_current = false;
    refresh_fit(clock);
}

static void double_width_pulse(struct gn_sample_clock *clock) {
    int64_t const beyond = clock->newest.strobe & (GN_CLOCK_WIDE_PULSE_EVERY - 1);
    if (beyond == 0) {
        clock->aligned = true;
        clock->suspected_offset = 0;
        return;
    }
    int64_t const offset = beyond >= GN_CLOCK_WIDE_PULSE_EVERY / 2 ? GN_CLOCK_WIDE_PULSE_EVERY - beyond : -beyond;
    /* One late falling edge must not move numbers that were confirmed: it takes two that say the same. */
    if (!clock->aligned || clock->suspected_offset == offset) {
        realign(clock, offset);
    } else {
        clock->suspected_offset = offset;
    }
}

static void falling(struct gn_sample_clock *clock, const struct gn_edge *edge) {
    if (!clock->pulse_open || edge->number != clock->last_number + 1u) {
        return; /* not the end of the newest strobe's pulse */
    }
    clock->pulse_open = false;
    int64_t const width_ns = edge->stamp_ns - clock->newest.stamp_ns;
    int64_t const eighth_ns = strobe_period_ns(clock) / 8;
    if (width_ns > 3 * eighth_ns && width_ns < 5 * eighth_ns) {
        double_width_pulse(clock);
    }
}

void gn_sample_clock_edge(struct gn_sample_clock *clock, const struct gn_edge *edge) {
    if (clock->running) {
        if (edge->rising) {
            rising(clock, edge);
        } else {
            falling(clock, edge);
        }
    }
    clock->last_number = edge->number;
}

/* The clock runs on without strobes for so long. */
static int64_t patience_ns(const struct gn_sample_clock *clock) {
    int64_t const four_strobes_ns = 4 * strobe_period_ns(clock);
    int64_t const settle_ns = clock->settings.settle_ns;
    return settle_ns > four_strobes_ns ? settle_ns : four_strobes_ns;
}

bool gn_sample_clock_settled(const struct gn_sample_clock *clock, int64_t now_ns) {
    return clock->running && clock->aligned && clock->count >= 2u &&
           clock->newest.stamp_ns - clock->points[clock->first].stamp_ns >= clock->settings.settle_ns &&
           now_ns - clock->newest.stamp_ns <= patience_ns(clock);
}

bool gn_sample_clock_silent(const struct gn_sample_clock *clock, int64_t now_ns) {
    return clock->running && clock->count > 0u && now_ns - clock->newest.stamp_ns > 2 * patience_ns(clock);
}

bool gn_sample_clock_fit(struct gn_sample_clock *clock, int64_t now_ns, struct gn_clock_fit *fit) {
    if (!gn_sample_clock_settled(clock, now_ns)) {
        return false;
    }
    refresh_fit(clock);
    *fit = clock->fit;
    return true;
}
