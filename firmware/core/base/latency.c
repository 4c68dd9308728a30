/* latency.c: the histogram's bins; stores are relaxed, a reader may see counts of neighbouring moments. */
#include "latency.h"

static void store(uint32_t *word, uint32_t value) {
    __atomic_store_n(word, value, __ATOMIC_RELAXED);
}

void gn_latency_record(struct gn_latency *latency, int64_t late_ns) {
    int64_t const late_us = late_ns < 0 ? 0 : late_ns / 1000;
    uint32_t bin = 0;
    while (bin + 1u < GN_LATENCY_BINS && late_us >> bin != 0) {
        ++bin;
    }
    store(&latency->bins[bin], latency->bins[bin] + 1u);
    store(&latency->wakeups, latency->wakeups + 1u);
    if (late_us > (int64_t)latency->max_us) {
        store(&latency->max_us, late_us > (int64_t)UINT32_MAX ? UINT32_MAX : (uint32_t)late_us);
    }
}
