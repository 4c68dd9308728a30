/* sync.h: SYNC producer with counter, its echo, and the pairing of TPDOs with SYNCs into pose records. */
#ifndef GONIO_SYNC_H
#define GONIO_SYNC_H

#include <stdbool.h>
#include <stdint.h>

#include "can.h"
#include "shared.h"

#define GN_SYNC_COB 0x080u
#define GN_SYNC_COUNTER_OVERFLOW 240u /* 0x1019 */

struct gn_sync {
    int64_t window_ns;      /* 0x1007 */
    uint32_t expected_mask; /* axes whose TPDO is due */
    uint32_t number;        /* of the last SYNC, from 1 */
    uint32_t echoes_lost_in_a_row;
    struct gn_motion_counters *counters;

    bool open; /* a SYNC was sent and its pose is not closed */
    bool echoed;
    int64_t sent_ns;
    int64_t echo_ns;
    bool echo_by_arrival; /* the echo's stamp is not the bus's: the clock stepped */
    uint32_t due_mask;    /* expected_mask at the SYNC */
    uint32_t seen_mask;
    uint32_t twice_mask;
    uint32_t late_mask;
    int32_t position_counts[GN_AXES]; /* of this SYNC */
    int32_t last_counts[GN_AXES];     /* last valid */
};

void gn_sync_init(struct gn_sync *sync, int64_t window_ns, struct gn_motion_counters *counters);
/* The next SYNC: `frame` is to be sent. Close the pose before. */
void gn_sync_begin(struct gn_sync *sync, int64_t now_ns, struct gn_can_frame *frame);
/* Own SYNC received back; true for the last SYNC's first echo. */
bool gn_sync_on_echo(struct gn_sync *sync, const struct gn_can_frame *frame);
/* Position of an axis, received at stamp_ns; true: it counts for the last SYNC. */
bool gn_sync_on_tpdo(struct gn_sync *sync, uint32_t axis, int32_t position_counts, int64_t stamp_ns);
/* The pose of the last SYNC, just before the next one: only now is it sure that no TPDO came twice. false: none due. */
bool gn_sync_close(struct gn_sync *sync, uint32_t known_mask, struct gn_pose *pose);

#endif
