/* log_stream.c: a bounded ring with a turn number per slot (many producers, one consumer): a line that finds no free
 * slot is dropped and counted, and the next line says how many were. */
#include "log_stream.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define SLOTS 256u /* a power of two; a burst of faults on all axes says fewer */
#define TEXT_SIZE 248u
#define WRITER_STACK 65536u /* memory is locked: every page of it counts */

/* turn == place: free for the producer of that place; place + 1: holds its line. */
struct slot {
    atomic_uint turn;
    enum gn_log_level level;
    char text[TEXT_SIZE];
};

struct gn_log_stream {
    int fd;
    pthread_t thread;
    sem_t filled;
    atomic_bool ending;
    atomic_uint write;
    atomic_uint dropped;
    unsigned read;
    unsigned dropped_told;
    struct slot slots[SLOTS];
};

static void put(void *context, enum gn_log_level level, const char *text) {
    struct gn_log_stream *log = context;
    unsigned place = atomic_load_explicit(&log->write, memory_order_relaxed);
    struct slot *slot = NULL;
    for (;;) {
        slot = &log->slots[place % SLOTS];
        unsigned const turn = atomic_load_explicit(&slot->turn, memory_order_acquire);
        if (turn != place) {
            if ((int)(turn - place) < 0) { /* still holds the line of a round ago: full */
                atomic_fetch_add_explicit(&log->dropped, 1u, memory_order_relaxed);
                return;
            }
            place = atomic_load_explicit(&log->write, memory_order_relaxed);
        } else if (atomic_compare_exchange_weak_explicit(&log->write, &place, place + 1u, memory_order_relaxed,
                                                         memory_order_relaxed)) {
            break;
        }
    }
    slot->level = level;
    size_t const length = strnlen(text, TEXT_SIZE - 1u);
    memcpy(slot->text, text, length);
    slot->text[length] = '\0';
    atomic_store_explicit(&slot->turn, place + 1u, memory_order_release);
    (void)sem_post(&log->filled);
}

/* One line in one write, so that lines of other processes do not get between. */
static void write_line(const struct gn_log_stream *log, enum gn_log_level level, const char *text) {
    char line[TEXT_SIZE + 8u];
    int const printed = snprintf(line, sizeof line, "<%d>%s\n", (int)level, text);
    size_t const length = (size_t)printed;
    size_t done = 0;
    while (done < length) {
        ssize_t const written = write(log->fd, line + done, length - done);
        if (written > 0) {
            done += (size_t)written;
        } else if (errno != EINTR) {
            return; /* nobody reads the log any more */
        }
    }
}

static void drain(struct gn_log_stream *log) {
    for (;;) {
        struct slot *slot = &log->slots[log->read % SLOTS];
        if (atomic_load_explicit(&slot->turn, memory_order_acquire) != log->read + 1u) {
            break;
        }
        write_line(log, slot->level, slot->text);
        atomic_store_explicit(&slot->turn, log->read + SLOTS, memory_order_release);
        ++log->read;
    }
    unsigned const dropped = atomic_load_explicit(&log->dropped, memory_order_relaxed);
    if (dropped != log->dropped_told) {
        char text[64];
        (void)snprintf(text, sizeof text, "log: %u lines dropped, they came too fast", dropped - log->dropped_told);
        log->dropped_told = dropped;
        write_line(log, GN_LOG_WARNING, text);
    }
}

static void *writer(void *context) {
    struct gn_log_stream *log = context;
    while (!atomic_load(&log->ending)) {
        if (sem_wait(&log->filled) == 0) {
            drain(log);
        }
    }
    drain(log);
    return NULL;
}

struct gn_log_stream *gn_log_stream_open(int fd) {
    static struct gn_log_stream the_log;
    struct gn_log_stream *log = &the_log;
    log->fd = fd;
    log->read = 0;
    log->dropped_told = 0;
    atomic_store(&log->ending, false);
    atomic_store(&log->write, 0u);
    atomic_store(&log->dropped, 0u);
    for (unsigned i = 0; i < SLOTS; ++i) {
        atomic_store(&log->slots[i].turn, i);
    }
    if (sem_init(&log->filled, 0, 0) != 0) {
        return NULL;
    }
    pthread_attr_t attributes;
    (void)pthread_attr_init(&attributes);
    (void)pthread_attr_setstacksize(&attributes, WRITER_STACK);
    int const failure = pthread_create(&log->thread, &attributes, writer, log);
    (void)pthread_attr_destroy(&attributes);
    return failure == 0 ? log : NULL;
}

void gn_log_stream_close(struct gn_log_stream *log) {
    atomic_store(&log->ending, true);
    (void)sem_post(&log->filled);
    (void)pthread_join(log->thread, NULL);
    (void)sem_destroy(&log->filled);
}

void gn_log_stream_port(struct gn_log_stream *log, struct gn_log_port *port) {
    *port = (struct gn_log_port){log, put};
}
