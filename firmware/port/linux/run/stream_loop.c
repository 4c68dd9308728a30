/* stream_loop.c: the stream thread: sleeps until bytes, packets, the order to end or the time that the core asked for.
 */
#include <poll.h>
#include <unistd.h>

#include "loops.h"
#include "realtime.h"

#define POLLS (1u + GN_LINK_POLLS + GN_DIGITISER_POLLS)
/* Half of what is promised to the watchdogs' keeper. */
#define ALIVE_NS INT64_C(50000000)
/* The real-time thread makes a round every 100 ms, for its status, even if nothing else happens. */
#define SILENCE_NS INT64_C(500000000)

struct signs_of_life {
    uint32_t beats;
    int64_t beat_ns;
    int64_t told_ns;
};

static void tell_alive(const struct gn_loops *loops, struct signs_of_life *signs, int64_t now_ns) {
    const struct gn_threads *threads = loops->threads;
    uint32_t const beats = __atomic_load_n(&loops->beats, __ATOMIC_RELAXED);
    if (beats != signs->beats) {
        signs->beats = beats;
        signs->beat_ns = now_ns;
    }
    if (threads->alive != NULL && now_ns - signs->beat_ns < SILENCE_NS && now_ns - signs->told_ns >= ALIVE_NS) {
        signs->told_ns = now_ns;
        threads->alive(threads->alive_context);
    }
}

static void wake_motion(const struct gn_loops *loops) {
    uint64_t const one = 1;
    (void)!write(loops->wake_fd, &one, sizeof one);
}

/* One round of the core. Knots can wait for the next SYNC cycle; commands and stops are not kept waiting. */
static int64_t process(const struct gn_loops *loops, int64_t now_ns) {
    const struct gn_threads *threads = loops->threads;
    struct gn_shared *shared = threads->shared;
    uint32_t const commands = shared->commands.write;
    uint32_t const stops = shared->stop_requested;
    if (threads->link != NULL) {
        gn_link_linux_process(threads->link);
    }
    if (threads->digitiser != NULL) {
        gn_digitiser_usb_process(threads->digitiser);
    }
    int64_t const due_ns = gn_stream_process(threads->stream, now_ns);
    if (shared->commands.write != commands || shared->stop_requested != stops) {
        wake_motion(loops);
    }
    return due_ns;
}

/* true: stop_fd is readable. */
static bool sleep_until(const struct gn_loops *loops, int64_t due_ns, bool ending) {
    const struct gn_threads *threads = loops->threads;
    struct pollfd polls[POLLS];
    uint32_t count = 0;
    polls[count++] = (struct pollfd){.fd = ending ? -1 : threads->stop_fd, .events = POLLIN};
    if (threads->link != NULL) {
        count += gn_link_linux_polls(threads->link, polls + count);
    }
    if (threads->digitiser != NULL) {
        count += gn_digitiser_usb_polls(threads->digitiser, polls + count);
    }
    struct timespec const timeout = gn_time_until(due_ns);
    return ppoll(polls, count, &timeout, NULL) > 0 && polls[0].revents != 0;
}

static void begin_end(struct gn_loops *loops) {
    __atomic_add_fetch(&loops->threads->shared->stop_requested, 1u, __ATOMIC_RELEASE);
    __atomic_store_n(&loops->ending, true, __ATOMIC_RELEASE);
    wake_motion(loops);
}

void gn_stream_loop(struct gn_loops *loops) {
    struct gn_latency *latency = &loops->threads->shared->stream_latency;
    struct signs_of_life signs = {.beat_ns = gn_monotonic_ns()};
    bool ending = false;
    bool ended = false;
    gn_realtime_enter(loops->settings->stream_priority, -1);
    while (!ended) {
        ended = __atomic_load_n(&loops->ended, __ATOMIC_ACQUIRE); /* one more round takes its last words along */
        int64_t const now_ns = gn_monotonic_ns();
        int64_t const due_ns = process(loops, now_ns);
        tell_alive(loops, &signs, now_ns);
        if (sleep_until(loops, due_ns, ending)) {
            ending = true;
            begin_end(loops);
        }
        int64_t const late_ns = gn_monotonic_ns() - due_ns;
        if (late_ns >= 0) {
            gn_latency_record(latency, late_ns);
        }
    }
}
