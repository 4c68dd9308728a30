/* boot_units.c: CiA 402: 0x6064 = increments * feed / (encoder resolution * gear ratio); it must be the increments. */
#include "boot_units.h"

#include <math.h>
#include <stdio.h>

/* 0x60A9 (CiA 303-2): prefix, numerator, denominator; increments, or plain numbers, per second. */
#define INCREMENTS_PER_S 0x00B50300u
#define NUMBERS_PER_S 0x00000300u

static bool refuse(struct gn_trouble *trouble, const struct gn_boot_step *step, const char *remedy) {
    trouble->code = gonio_FaultCode_FAULT_WRONG_DEVICE;
    trouble->index = step->index;
    trouble->subindex = step->subindex;
    trouble->remedy = remedy;
    return false;
}

static bool judge_velocity(uint32_t unit, const struct gn_boot_step *step, struct gn_trouble *trouble) {
    if (unit == INCREMENTS_PER_S || unit == NUMBERS_PER_S) {
        return true;
    }
    (void)snprintf(trouble->cause, sizeof trouble->cause, "0x60A9 (velocity unit) is 0x%08lX, not counts per second",
                   (unsigned long)unit);
    return refuse(trouble, step, "set it to 0x00B50300 with the maker's tool");
}

static bool judge_feed(const struct gn_axis *axis, const struct gn_boot_step *step, struct gn_trouble *trouble) {
    const uint32_t *gear = axis->boot.gear;
    const uint32_t *feed = axis->boot.feed;
    double const counts = (double)axis->config.counts_per_turn * gear[0] / gear[1];
    double const per_shaft = (double)feed[0] / feed[1];
    if (!(fabs(per_shaft - counts) < 0.5)) {
        (void)snprintf(trouble->cause, sizeof trouble->cause,
                       "0x6092 (feed) makes %.0f units of a shaft revolution that has %.0f encoder counts", per_shaft,
                       counts);
        return refuse(trouble, step, "set 0x6092 so that positions are encoder counts");
    }
    /* A gear that the drive knows of is the whole way to the axis; of one outside it nothing can be said here. */
    double const per_axis_turn = 360.0 * fabs(axis->config.counts_per_deg);
    if (gear[0] != gear[1] && !(fabs(per_shaft - per_axis_turn) < 0.5)) {
        (void)snprintf(trouble->cause, sizeof trouble->cause,
                       "0x6091 and 0x6092 make %.0f counts per turn, counts_per_deg makes %.0f", per_shaft,
                       per_axis_turn);
        return refuse(trouble, step, "check 0x6091 and counts_per_deg");
    }
    return true;
}

bool gn_boot_units(struct gn_axis *axis, const struct gn_boot_step *step, struct gn_trouble *trouble) {
    uint32_t const found = gn_sdo_value(&axis->sdo);
    if (step->index == 0x60A9u) {
        return judge_velocity(found, step, trouble);
    }
    (step->index == 0x6091u ? axis->boot.gear : axis->boot.feed)[step->subindex - 1u] = found;
    bool const feed_known = step->index == 0x6092u && step->subindex == 2u;
    return !feed_known || judge_feed(axis, step, trouble);
}
