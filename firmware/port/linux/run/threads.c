/* threads.c: starts the real-time thread, runs the stream loop, and leaves the instrument dark. */
#include "threads.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "loops.h"
#include "realtime.h"

int64_t gn_monotonic_ns(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* Signals are for the caller's thread. 0, or an errno. */
static int start(pthread_t *thread, struct gn_loops *loops) {
    pthread_attr_t attributes;
    sigset_t all;
    sigset_t before;
    int result = pthread_attr_init(&attributes);
    if (result != 0) {
        return result;
    }
    (void)sigfillset(&all);
    (void)pthread_attr_setstacksize(&attributes, GN_STACK_BYTES);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    result = pthread_create(thread, &attributes, gn_motion_loop, loops);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    (void)pthread_attr_destroy(&attributes);
    if (result == 0) {
        (void)pthread_setname_np(*thread, "goniod-motion");
    }
    return result;
}

/* Whatever became of the core. */
static void outputs_off(struct gn_gpio_lines *gpio) {
    struct gn_edge_port edge;
    struct gn_out_port out;
    gn_gpio_ports(gpio, &edge, &out);
    out.set(out.context, GN_OUT_SHUTTER, false);
    out.set(out.context, GN_OUT_LAMP, false);
}

int gn_threads_run(const struct gn_threads *threads, const struct gn_thread_settings *settings, char *error,
                   size_t error_size) {
    struct gn_loops loops = {
        .threads = threads, .settings = settings, .wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    pthread_t motion;
    if (loops.wake_fd < 0) {
        (void)snprintf(error, error_size, "eventfd: %s", strerror(errno));
        return -1;
    }
    int const result = start(&motion, &loops);
    if (result == 0) {
        gn_stream_loop(&loops);
        (void)pthread_join(motion, NULL);
    } else {
        (void)snprintf(error, error_size, "the real-time thread does not start: %s; raise LimitMEMLOCK or LimitNPROC",
                       strerror(result));
    }
    if (threads->gpio != NULL) {
        outputs_off(threads->gpio);
    }
    (void)close(loops.wake_fd);
    return result == 0 ? 0 : -1;
}
