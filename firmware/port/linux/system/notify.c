/* notify.c: one datagram per state to the socket that systemd names; its library is not needed for that. */
#include "notify.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

bool gn_notify(const char *state) {
    const char *path = getenv("NOTIFY_SOCKET");
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    size_t const length = path == NULL ? 0u : strlen(path);
    if (length < 2u || length >= sizeof address.sun_path || (path[0] != '/' && path[0] != '@')) {
        return false;
    }
    memcpy(address.sun_path, path, length);
    if (path[0] == '@') {
        address.sun_path[0] = '\0'; /* Linux: an abstract name */
    }
    int const fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) {
        return false;
    }
    socklen_t const size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + length);
    ssize_t const sent = sendto(fd, state, strlen(state), MSG_NOSIGNAL, (const struct sockaddr *)&address, size);
    (void)close(fd);
    return sent == (ssize_t)strlen(state);
}

/* A whole decimal number above 0 from the environment, else 0. */
static long long number_of(const char *name) {
    const char *text = getenv(name);
    char *end = NULL;
    long long const number = text == NULL ? 0 : strtoll(text, &end, 10);
    return number > 0 && *end == '\0' ? number : 0;
}

int64_t gn_notify_watchdog_ns(void) {
    long long const interval_us = number_of("WATCHDOG_USEC");
    long long const pid = number_of("WATCHDOG_PID");
    bool const ours = getenv("WATCHDOG_PID") == NULL || pid == (long long)getpid();
    return ours && interval_us > 0 && interval_us < INT64_MAX / 1000 ? interval_us * 1000 : 0;
}
