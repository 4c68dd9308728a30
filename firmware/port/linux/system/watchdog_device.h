/* watchdog_device.h: the board's hardware watchdog (/dev/watchdog): resets the board when it is not kept alive. */
#ifndef GONIO_WATCHDOG_DEVICE_H
#define GONIO_WATCHDOG_DEVICE_H

#include <stddef.h>

/* Arms the watchdog. -1, and one line in `error`. Empty path: -1 without an error line, there is none. */
int gn_watchdog_open(const char *path, char *error, size_t error_size);
void gn_watchdog_keep_alive(int fd);
/* Disarms it (the magic close), for a controlled end. */
void gn_watchdog_close(int fd);

#endif
