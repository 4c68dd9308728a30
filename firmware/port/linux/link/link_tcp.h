/* link_tcp.h: clients over TCP, on loopback only: whoever may log in may drive; from elsewhere one comes through ssh.
 */
#ifndef GONIO_LINK_TCP_H
#define GONIO_LINK_TCP_H

#include <poll.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "link.h"

#define GN_TCP_CLIENTS (GN_LINK_CLIENTS - 1u) /* client 0 is USB */
#define GN_TCP_POLLS (GN_TCP_CLIENTS + 1u)

struct gn_tcp_client {
    int fd;     /* -1: none */
    bool heard; /* the core reads it; a client that is being dismissed is not read, and must not wake the thread */
    bool full;  /* the kernel took less than there was */
};

struct gn_link_tcp {
    int listener;
    uint16_t port;
    struct gn_tcp_client clients[GN_TCP_CLIENTS];
};

/* Port 0: any free one. false, and one line in `error`. */
bool gn_link_tcp_open(struct gn_link_tcp *tcp, uint16_t port, char *error, size_t error_size);
void gn_link_tcp_close(struct gn_link_tcp *tcp);
/* Accepts; a connection for which there is no place is closed at once. */
void gn_link_tcp_process(struct gn_link_tcp *tcp);
/* As in gn_link_port; clients from 0. */
int gn_link_tcp_read(struct gn_link_tcp *tcp, uint32_t client, uint8_t *buffer, size_t capacity);
int gn_link_tcp_write(struct gn_link_tcp *tcp, uint32_t client, const uint8_t *bytes, size_t length);
void gn_link_tcp_dismiss(struct gn_link_tcp *tcp, uint32_t client);
/* At most GN_TCP_POLLS. */
uint32_t gn_link_tcp_polls(const struct gn_link_tcp *tcp, struct pollfd *polls);

#endif
