/* acquisition.h: the digitiser while it runs: packets, strobes and the sample blocks made of them. */
#ifndef GONIO_ACQUISITION_H
#define GONIO_ACQUISITION_H

#include <stdbool.h>

#include "blocks.h"
#include "digitiser.h"
#include "digitiser_packets.h"
#include "ring.h"
#include "sample_clock.h"
#include "session.h"

struct gn_acquisition {
    const struct gn_digitiser_port *digitiser;
    struct gn_ring *strobes; /* struct gn_edge */
    struct gn_session *session;
    bool on;
    struct gn_digitiser_packets packets;
    struct gn_sample_clock clock;
    struct gn_sample_blocks blocks;
};

/* false: the digitiser does not answer. */
bool gn_acquisition_start(struct gn_acquisition *acquisition, const gonio_Configure *configuration);
/* Sends what is left, also of the packets still waiting. */
void gn_acquisition_stop(struct gn_acquisition *acquisition, int64_t now_ns);
/* Takes all strobes and packets that wait. NULL, or why acquisition has ended: the digitiser was unplugged, or its
 * strobe stays away. */
const char *gn_acquisition_process(struct gn_acquisition *acquisition, int64_t now_ns);

#endif
