/* latency.h: how late a thread woke up, as a histogram with bins that double; one writer, read by another thread. */
#ifndef GONIO_LATENCY_H
#define GONIO_LATENCY_H

#include <stdint.h>

#define GN_LATENCY_BINS 20u

struct gn_latency {
    uint32_t wakeups;
    uint32_t max_us;
    uint32_t bins[GN_LATENCY_BINS]; /* bin 0: less than 1 us late, bin i: less than 2^i us, the last: all later ones */
};

/* A wake-up came late_ns after its time; less than 0 is taken as in time. */
void gn_latency_record(struct gn_latency *latency, int64_t late_ns);

#endif
