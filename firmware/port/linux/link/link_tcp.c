/* link_tcp.c: non-blocking sockets on 127.0.0.1. */
#include "link_tcp.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define BACKLOG 4
#define DRAIN_READS 16u /* what a dismissed client still had under way; more than that it has to lose */

static bool listen_on(struct gn_link_tcp *tcp, uint16_t port) {
    int const on = 1;
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons(port)};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    tcp->listener = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (tcp->listener < 0 || setsockopt(tcp->listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
        bind(tcp->listener, (struct sockaddr *)&address, sizeof address) != 0 || listen(tcp->listener, BACKLOG) != 0 ||
        getsockname(tcp->listener, (struct sockaddr *)&address, &length) != 0) {
        return false;
    }
    tcp->port = ntohs(address.sin_port);
    return true;
}

bool gn_link_tcp_open(struct gn_link_tcp *tcp, uint16_t port, char *error, size_t error_size) {
    *tcp = (struct gn_link_tcp){.listener = -1};
    for (uint32_t i = 0; i < GN_TCP_CLIENTS; ++i) {
        tcp->clients[i].fd = -1;
    }
    if (!listen_on(tcp, port)) {
        const char *remedy = errno == EADDRINUSE ? "; is another goniod running? choose another link.tcp_port" : "";
        (void)snprintf(error, error_size, "link: cannot listen on 127.0.0.1:%u: %s%s", (unsigned)port, strerror(errno),
                       remedy);
        gn_link_tcp_close(tcp);
        return false;
    }
    return true;
}

static void drop(struct gn_tcp_client *client) {
    if (client->fd >= 0) {
        (void)close(client->fd);
    }
    *client = (struct gn_tcp_client){.fd = -1};
}

void gn_link_tcp_close(struct gn_link_tcp *tcp) {
    for (uint32_t i = 0; i < GN_TCP_CLIENTS; ++i) {
        gn_link_tcp_dismiss(tcp, i);
    }
    if (tcp->listener >= 0) {
        (void)close(tcp->listener);
        tcp->listener = -1;
    }
}

static void take_in(struct gn_link_tcp *tcp, int fd) {
    int const on = 1;
    for (uint32_t i = 0; i < GN_TCP_CLIENTS; ++i) {
        if (tcp->clients[i].fd < 0) {
            (void)setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
            tcp->clients[i] = (struct gn_tcp_client){.fd = fd, .heard = true};
            return;
        }
    }
    (void)close(fd);
}

void gn_link_tcp_process(struct gn_link_tcp *tcp) {
    for (int i = 0; i < BACKLOG; ++i) {
        int const fd = accept4(tcp->listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (fd < 0) {
            break;
        }
        take_in(tcp, fd);
    }
    for (uint32_t i = 0; i < GN_TCP_CLIENTS; ++i) {
        /* Until the core has asked again, nothing of this client is worth a wake-up. */
        tcp->clients[i].heard = false;
        tcp->clients[i].full = false;
    }
}

static bool only_later(void) {
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

int gn_link_tcp_read(struct gn_link_tcp *tcp, uint32_t number, uint8_t *buffer, size_t capacity) {
    struct gn_tcp_client *client = &tcp->clients[number];
    if (client->fd < 0) {
        return -1;
    }
    client->heard = true;
    ssize_t const length = recv(client->fd, buffer, capacity, 0);
    if (length > 0) {
        return (int)length;
    }
    if (length < 0 && only_later()) {
        return 0;
    }
    drop(client);
    return -1;
}

int gn_link_tcp_write(struct gn_link_tcp *tcp, uint32_t number, const uint8_t *bytes, size_t length) {
    struct gn_tcp_client *client = &tcp->clients[number];
    if (client->fd < 0) {
        return -1;
    }
    ssize_t const taken = send(client->fd, bytes, length, MSG_NOSIGNAL);
    if (taken < 0 && !only_later()) {
        drop(client);
        return -1;
    }
    client->full = taken < (ssize_t)length;
    return taken < 0 ? 0 : (int)taken;
}

void gn_link_tcp_dismiss(struct gn_link_tcp *tcp, uint32_t number) {
    struct gn_tcp_client *client = &tcp->clients[number];
    if (client->fd < 0) {
        return;
    }
    /* A socket closed with bytes unread sends a reset, which may overtake our last words. */
    uint8_t rest[4096];
    (void)shutdown(client->fd, SHUT_WR);
    for (uint32_t i = 0; i < DRAIN_READS && recv(client->fd, rest, sizeof rest, 0) > 0; ++i) {
    }
    drop(client);
}

uint32_t gn_link_tcp_polls(const struct gn_link_tcp *tcp, struct pollfd *polls) {
    uint32_t count = 0;
    polls[count++] = (struct pollfd){.fd = tcp->listener, .events = POLLIN};
    for (uint32_t i = 0; i < GN_TCP_CLIENTS; ++i) {
        const struct gn_tcp_client *client = &tcp->clients[i];
        short const events = (short)((client->heard ? POLLIN : 0) | (client->full ? POLLOUT : 0));
        if (client->fd >= 0 && events != 0) { /* without events a hung-up socket would still wake the thread */
            polls[count++] = (struct pollfd){.fd = client->fd, .events = events};
        }
    }
    return count;
}
