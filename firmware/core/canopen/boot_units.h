/* boot_units.h: are the drive's units ours? Gear (0x6091) and feed (0x6092) against counts_per_turn and counts_per_deg,
 * the velocity unit (0x60A9) against counts per second; each only where the drive has it. */
#ifndef GONIO_BOOT_UNITS_H
#define GONIO_BOOT_UNITS_H

#include "axis.h"
#include "boot_steps.h"
#include "trouble.h"

/* Take the value just read for this step. false: the drive counts in other units, the trouble says which. */
bool gn_boot_units(struct gn_axis *axis, const struct gn_boot_step *step, struct gn_trouble *trouble);

#endif
