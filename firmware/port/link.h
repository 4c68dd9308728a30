/* link.h: the seam of the byte streams to the clients: one drives, the others may visit (info and stop only). */
#ifndef GONIO_PORT_LINK_H
#define GONIO_PORT_LINK_H

#include <stddef.h>
#include <stdint.h>

#define GN_LINK_CLIENTS 3u

struct gn_link_port {
    void *context;
    /* Bytes read, 0: none waiting, -1: no client (or gone). */
    int (*read)(void *context, uint32_t client, uint8_t *buffer, size_t capacity);
    /* Bytes taken (may be fewer), -1: no client (or gone). */
    int (*write)(void *context, uint32_t client, const uint8_t *bytes, size_t length);
    void (*close)(void *context, uint32_t client);
};

#endif
