/* motion.c: the real-time thread's entry point, in order: edges, frames, requests, stop and expiry, cycle, status. */
#include "motion.h"

#include "commands.h"
#include "cycle.h"
#include "inputs.h"
#include "motion_state.h"
#include "notice.h"
#include "operation.h"
#include "outputs.h"
#include "ride.h"

#define STATUS_PERIOD_NS 100000000

struct gn_motion *gn_motion_init(const struct gn_port *port, struct gn_shared *shared) {
    static struct gn_motion instance;
    struct gn_motion *motion = &instance;
    *motion = (struct gn_motion){.port = port, .shared = shared};
    motion->stops_seen = __atomic_load_n(&shared->stop_requested, __ATOMIC_ACQUIRE);
    motion->sync.counters = &shared->counters;
    gn_path_init(&motion->path);
    gn_inputs_init(motion);
    return motion;
}

static void halt(struct gn_motion *motion, gonio_PathEnd end, const char *why) {
    if (motion->state == gonio_InstrumentState_STATE_MOVING) {
        gn_ride_halt(motion, end);
    } else if (motion->state == gonio_InstrumentState_STATE_HOMING) {
        gn_home_halt(motion, why);
        gn_shutter_close_when_still(motion);
    } else if (motion->path.state == GN_PATH_IDLE && !motion->dark_when_still) {
        gn_shutter_close(motion);
    }
}

static void stop_process(struct gn_motion *motion) {
    uint32_t const requested = __atomic_load_n(&motion->shared->stop_requested, __ATOMIC_ACQUIRE);
    if (requested != motion->stops_seen) {
        motion->stops_seen = requested;
        halt(motion, gonio_PathEnd_PATH_STOPPED, "stopped by request; home again");
    }
}

/* The driver's silence counts from its last word, also when it is gone for good. When it has lasted for the expiry, all
 * stands and is dark: the stop begins earlier by as long as it may take. */
static void expiry_process(struct gn_motion *motion) {
    int64_t const heard_ns = __atomic_load_n(&motion->shared->host_heard_ns, __ATOMIC_RELAXED);
    if (heard_ns > motion->heard_ns) {
        motion->heard_ns = heard_ns;
    }
    if (motion->configured && motion->now_ns - motion->heard_ns > gn_ride_patience_ns(&motion->cycle)) {
        halt(motion, gonio_PathEnd_PATH_EXPIRED, "stopped: no word from the host in time; home again");
    }
}

int64_t gn_motion_process(struct gn_motion *motion, int64_t now_ns) {
    motion->now_ns = now_ns;
    gn_inputs_process(motion);
    gn_frames_process(motion);
    uint32_t const knots = gn_ring_fill(&motion->shared->knots); /* before the commands: their MotionBegin is there */
    gn_commands_process(motion);
    gn_ride_take_knots(motion, knots);
    stop_process(motion);
    expiry_process(motion);
    gn_operation_process(motion);
    gn_errand_process(motion);
    gn_cycle_process(motion);
    if (now_ns >= motion->next_status_ns) {
        motion->next_status_ns += ((now_ns - motion->next_status_ns) / STATUS_PERIOD_NS + 1) * STATUS_PERIOD_NS;
        gn_event_status(motion);
    }
    int64_t const cycle_ns = gn_cycle_next_ns(motion);
    return cycle_ns < motion->next_status_ns ? cycle_ns : motion->next_status_ns;
}
