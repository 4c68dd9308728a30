/* sync.c: SYNC producer and the pairing of TPDOs with SYNCs. */
#include "sync.h"

static void count(uint32_t *counter) {
    __atomic_store_n(counter, *counter + 1u, __ATOMIC_RELAXED);
}

void gn_sync_init(struct gn_sync *sync, int64_t window_ns, struct gn_motion_counters *counters) {
    uint32_t const number = sync->number; /* numbers go on: they are unique since boot */
    *sync = (struct gn_sync){.window_ns = window_ns, .number = number, .counters = counters};
}

static uint8_t counter_of(uint32_t number) {
    return (uint8_t)((number - 1u) % GN_SYNC_COUNTER_OVERFLOW + 1u);
}

void gn_sync_begin(struct gn_sync *sync, int64_t now_ns, struct gn_can_frame *frame) {
    sync->number++;
    count(&sync->counters->syncs);
    sync->open = true;
    sync->echoed = false;
    sync->sent_ns = now_ns;
    sync->echo_ns = 0;
    sync->echo_by_arrival = false;
    sync->due_mask = sync->expected_mask;
    sync->seen_mask = 0;
    sync->twice_mask = 0;
    sync->late_mask = 0;
    *frame = (struct gn_can_frame){.id = GN_SYNC_COB, .length = 1, .data = {counter_of(sync->number)}};
}

bool gn_sync_on_echo(struct gn_sync *sync, const struct gn_can_frame *frame) {
    if (!sync->open || sync->echoed || frame->length != 1u || frame->data[0] != counter_of(sync->number)) {
        return false;
    }
    sync->echoed = true;
    sync->echo_ns = frame->stamp_ns;
    sync->echo_by_arrival = frame->stamp_by_arrival;
    sync->echoes_lost_in_a_row = 0;
    return true;
}

bool gn_sync_on_tpdo(struct gn_sync *sync, uint32_t axis, int32_t position_counts, int64_t stamp_ns) {
    uint32_t const bit = 1u << axis;
    if (!sync->open || (sync->due_mask & bit) == 0u) {
        return false;
    }
    if (sync->seen_mask & bit) {
        sync->twice_mask |= bit;
        count(&sync->counters->tpdo_duplicate);
        return false;
    }
    if (!sync->echoed || stamp_ns - sync->echo_ns > sync->window_ns) {
        sync->late_mask |= bit;
        count(&sync->counters->tpdo_late);
        return false;
    }
    sync->seen_mask |= bit;
    sync->position_counts[axis] = position_counts;
    return true;
}

bool gn_sync_close(struct gn_sync *sync, uint32_t known_mask, struct gn_pose *pose) {
    if (!sync->open) {
        return false;
    }
    sync->open = false;
    if (!sync->echoed) {
        sync->echoes_lost_in_a_row++;
        count(&sync->counters->sync_echoes_lost);
    }
    if (sync->due_mask == 0u) {
        return false;
    }
    uint32_t const valid = sync->seen_mask & ~sync->twice_mask;
    uint32_t flags = sync->echoed ? 0u : GN_POSE_ECHO_LOST;
    flags |= sync->echo_by_arrival ? GN_POSE_CLOCK_STEP : 0u;
    flags |= sync->late_mask ? GN_POSE_TPDO_LATE : 0u;
    flags |= sync->twice_mask ? GN_POSE_TPDO_DUPLICATE : 0u;
    flags |= (known_mask & sync->due_mask) != sync->due_mask ? GN_POSE_POSITION_UNKNOWN : 0u;
    *pose = (struct gn_pose){
        .sync_time_ns = sync->echoed ? sync->echo_ns : sync->sent_ns,
        .sync_number = sync->number,
        .valid = (uint8_t)valid,
    };
    for (uint32_t axis = 0; axis < GN_AXES; axis++) {
        uint32_t const bit = 1u << axis;
        if (valid & bit) {
            sync->last_counts[axis] = sync->position_counts[axis];
        } else if ((sync->due_mask & bit) && !((sync->seen_mask | sync->late_mask) & bit)) {
            count(&sync->counters->tpdo_missing);
            flags |= GN_POSE_TPDO_MISSING;
        }
        pose->position_counts[axis] = sync->last_counts[axis];
    }
    pose->flags = (uint8_t)flags;
    return true;
}
