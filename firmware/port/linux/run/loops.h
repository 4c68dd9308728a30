/* loops.h: what the two loops share beside gn_shared: wake-ups, signs of life and the order to end. */
#ifndef GONIO_LOOPS_H
#define GONIO_LOOPS_H

#include <stdbool.h>
#include <stdint.h>
#include <time.h>

#include "threads.h"

/* On the way out: a hold on the path takes GN_PATH_HOLD_MS (2 s) at most, the shutter's deadline and travel 0.3 s. */
#define GN_END_NS INT64_C(3000000000)

struct gn_loops {
    const struct gn_threads *threads;
    const struct gn_thread_settings *settings;
    int wake_fd;    /* eventfd: the stream thread has a command for the real-time thread */
    uint32_t beats; /* motion -> stream, atomic: rounds of the real-time thread */
    bool ending;    /* stream -> motion, atomic; stop_requested was counted up before */
    bool ended;     /* motion -> stream, atomic */
};

/* Until `ending` and all stands dark, or GN_END_NS later. */
void *gn_motion_loop(void *loops);
/* Until stop_fd is readable and the real-time thread has ended. */
void gn_stream_loop(struct gn_loops *loops);

/* Time-out for ppoll(). */
static inline struct timespec gn_time_until(int64_t due_ns) {
    int64_t const now_ns = gn_monotonic_ns();
    int64_t const left_ns = due_ns > now_ns ? due_ns - now_ns : 0;
    return (struct timespec){.tv_sec = (time_t)(left_ns / 1000000000), .tv_nsec = (long)(left_ns % 1000000000)};
}

#endif
