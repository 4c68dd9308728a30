/* realtime.h: what makes a thread a real-time thread: priority, processor, timers without slack, stack in memory. */
#ifndef GONIO_REALTIME_H
#define GONIO_REALTIME_H

#include <stdbool.h>
#include <stddef.h>

/* Of the real-time thread; the core's deepest call needs a tenth. All of it is locked. */
#define GN_STACK_BYTES ((size_t)256 * 1024)

/* For the calling thread. priority 0 and cpu -1 leave things as they are. What is refused is left as it is:
 * gn_realtime_prepare() has said so. */
void gn_realtime_enter(int priority, int cpu);

#endif
