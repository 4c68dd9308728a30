/* boot_judge.h: is the value that boot has just read the right one? */
#ifndef GONIO_BOOT_JUDGE_H
#define GONIO_BOOT_JUDGE_H

#include "axis.h"
#include "boot_steps.h"
#include "trouble.h"

/* Judge the value in axis->sdo for this step, and keep it where it is asked for. false: the trouble says why. */
bool gn_boot_judge(struct gn_axis *axis, const struct gn_bus *bus, const struct gn_boot_step *step,
                   struct gn_trouble *trouble);

#endif
