/* watchdog_device.c: the kernel's watchdog interface: any write keeps alive, 'V' before the close disarms. */
#include "watchdog_device.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/watchdog.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define TIMEOUT_S 10 /* longer than systemd's WatchdogSec of 2 s, which restarts goniod before the board is reset */

int gn_watchdog_open(const char *path, char *error, size_t error_size) {
    if (path[0] == '\0') {
        return -1;
    }
    int const fd = open(path, O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) {
        (void)snprintf(error, error_size, "watchdog.device %s: %s; %s", path, strerror(errno),
                       errno == EBUSY ? "another program has it (systemd's RuntimeWatchdogSec?), set none or end that"
                                      : "name the board's watchdog, or set none");
        return -1;
    }
    int timeout_s = TIMEOUT_S;
    if (ioctl(fd, WDIOC_SETTIMEOUT, &timeout_s) != 0 && errno != EOPNOTSUPP && errno != EINVAL) {
        (void)snprintf(error, error_size, "watchdog.device %s: %s", path, strerror(errno));
        gn_watchdog_close(fd);
        return -1;
    }
    return fd;
}

void gn_watchdog_keep_alive(int fd) {
    if (fd >= 0) {
        (void)!write(fd, "k", 1);
    }
}

void gn_watchdog_close(int fd) {
    if (fd >= 0) {
        (void)!write(fd, "V", 1);
        (void)close(fd);
    }
}
