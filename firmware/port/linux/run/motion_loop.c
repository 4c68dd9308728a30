/* motion_loop.c: the real-time thread: sleeps until a frame, an edge, a command or the time that the core asked for. */
#include <poll.h>
#include <unistd.h>

#include "loops.h"
#include "motion_state.h"
#include "realtime.h"

#define POLLS (2u + GN_GPIO_FDS)
/* The drives lag their last target by some milliseconds. */
#define STILL_CYCLES 5u

/* The core was told to stop, and did. Without a configuration there is nothing to be waited for. */
static bool stands_dark(const struct gn_motion *motion) {
    bool const still = !motion->configured || motion->still_cycles >= STILL_CYCLES;
    return motion->path.state == GN_PATH_IDLE && !motion->shutter_open && still;
}

static uint32_t collect(const struct gn_loops *loops, struct pollfd polls[POLLS]) {
    const struct gn_threads *threads = loops->threads;
    uint32_t count = 0;
    polls[count++] = (struct pollfd){.fd = loops->wake_fd, .events = POLLIN};
    if (threads->can != NULL) { /* ppoll leaves out a descriptor of -1 */
        polls[count++] = (struct pollfd){.fd = gn_can_socket_fd(threads->can), .events = POLLIN};
    }
    if (threads->gpio != NULL) {
        int fds[GN_GPIO_FDS];
        uint32_t const lines = gn_gpio_fds(threads->gpio, fds);
        for (uint32_t i = 0; i < lines; i++) {
            polls[count++] = (struct pollfd){.fd = fds[i], .events = POLLIN};
        }
    }
    return count;
}

static void sleep_until(const struct gn_loops *loops, int64_t due_ns) {
    struct pollfd polls[POLLS];
    uint32_t const count = collect(loops, polls);
    struct timespec const timeout = gn_time_until(due_ns);
    if (ppoll(polls, count, &timeout, NULL) > 0 && polls[0].revents != 0) {
        uint64_t wakes = 0;
        (void)!read(loops->wake_fd, &wakes, sizeof wakes);
    }
}

void *gn_motion_loop(void *argument) {
    struct gn_loops *loops = argument;
    const struct gn_threads *threads = loops->threads;
    int64_t end_ns = GN_NEVER_NS;
    gn_realtime_enter(loops->settings->motion_priority, loops->settings->motion_cpu);
    for (;;) {
        bool const ending = __atomic_load_n(&loops->ending, __ATOMIC_ACQUIRE);
        int64_t const now_ns = gn_monotonic_ns();
        int64_t due_ns = GN_NEVER_NS;
        if (threads->can != NULL) {
            due_ns = gn_can_socket_process(threads->can, now_ns);
        }
        int64_t const core_due_ns = gn_motion_process(threads->motion, now_ns);
        __atomic_add_fetch(&loops->beats, 1u, __ATOMIC_RELAXED);
        if (ending && end_ns == GN_NEVER_NS) {
            end_ns = now_ns + GN_END_NS;
        }
        if (now_ns >= end_ns || (ending && stands_dark(threads->motion))) {
            break;
        }
        due_ns = core_due_ns < due_ns ? core_due_ns : due_ns;
        sleep_until(loops, due_ns);
        int64_t const late_ns = gn_monotonic_ns() - core_due_ns;
        if (late_ns >= 0) { /* the time has come, even if a frame came at the same moment */
            gn_latency_record(&threads->shared->motion_latency, late_ns);
        }
    }
    __atomic_store_n(&loops->ended, true, __ATOMIC_RELEASE);
    return NULL;
}
