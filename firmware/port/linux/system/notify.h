/* notify.h: what systemd is told over NOTIFY_SOCKET (sd_notify(3)): READY=1, WATCHDOG=1, STATUS=..., STOPPING=1. */
#ifndef GONIO_NOTIFY_H
#define GONIO_NOTIFY_H

#include <stdbool.h>
#include <stdint.h>

/* Sends one state, e.g. "READY=1"; false: no NOTIFY_SOCKET, or nobody listens. Never waits. */
bool gn_notify(const char *state);
/* How often systemd must hear WATCHDOG=1 (WATCHDOG_USEC, if meant for this process); 0: it does not ask. */
int64_t gn_notify_watchdog_ns(void);

#endif
