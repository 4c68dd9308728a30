/* commands.h: the host's requests, as far as they concern the real-time thread. */
#ifndef GONIO_COMMANDS_H
#define GONIO_COMMANDS_H

#include "motion_state.h"

void gn_commands_process(struct gn_motion *motion);
/* The answer of an SdoRead, when it came. */
void gn_errand_process(struct gn_motion *motion);

#endif
