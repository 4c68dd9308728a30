/* threads.h: the two threads of the firmware on Linux: memory locked, SCHED_FIFO, wake-ups measured. */
#ifndef GONIO_THREADS_H
#define GONIO_THREADS_H

#include <stdbool.h>
#include <stddef.h>

#include "can_socket.h"
#include "digitiser_usb.h"
#include "gpio_lines.h"
#include "link_linux.h"
#include "motion.h"
#include "shared.h"
#include "stream.h"

struct gn_thread_settings {
    int motion_priority; /* SCHED_FIFO; 0: leave as it is */
    int stream_priority;
    int motion_cpu; /* -1: any */
};

/* Whatever is NULL is not served (the self-test has no devices). */
struct gn_threads {
    struct gn_can_socket *can;
    struct gn_gpio_lines *gpio;
    struct gn_digitiser_usb *digitiser;
    struct gn_link_linux *link;
    struct gn_motion *motion;
    struct gn_stream *stream;
    struct gn_shared *shared;
    /* Called on the stream thread at least every 100 ms while both threads are alive: systemd and hardware watchdog. */
    void (*alive)(void *context);
    void *alive_context;
    int stop_fd; /* readable: end (a signalfd or an eventfd) */
};

/* Locks and prefaults memory; describes the kernel (name, release, PREEMPT_RT or not) for Info. false: not all of it
 * could be had; `problem` says what and how to mend it. The firmware runs nevertheless, and says so. */
bool gn_realtime_prepare(const struct gn_thread_settings *settings, char *kernel, size_t kernel_size, bool *preempt_rt,
                         char *problem, size_t problem_size);
/* Runs the real-time thread beside the stream thread (the caller's) until stop_fd; then closes the shutter, joins.
 * 0, or -1 with one line in `error`. */
int gn_threads_run(const struct gn_threads *threads, const struct gn_thread_settings *settings, char *error,
                   size_t error_size);
int64_t gn_monotonic_ns(void);

#endif
