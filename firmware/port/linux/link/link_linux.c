/* link_linux.c: which client is on which carrier. */
#include "link_linux.h"

#include <stdio.h>
#include <string.h>

#include "link_ffs.h"
#include "link_tcp.h"

#define USB_CLIENT 0u

_Static_assert(GN_FFS_POLLS + GN_TCP_POLLS <= GN_LINK_POLLS, "every carrier has its polls");

struct gn_link_linux {
    bool usb;
    bool tcp_open;
    struct gn_link_ffs ffs;
    struct gn_link_tcp tcp;
};

struct gn_link_linux *gn_link_linux_open(const struct gn_link_settings *settings, char *error, size_t error_size) {
    static struct gn_link_linux the_link;
    struct gn_link_linux *link = &the_link;
    memset(link, 0, sizeof *link);
    if (settings->functionfs[0] == '\0' && !settings->tcp) {
        (void)snprintf(error, error_size, "link: neither USB nor TCP: set link.functionfs or link.tcp_port");
        return NULL;
    }
    if (settings->functionfs[0] != '\0') {
        link->usb = gn_link_ffs_open(&link->ffs, settings->functionfs, error, error_size);
        if (!link->usb) {
            return NULL;
        }
    }
    if (settings->tcp) {
        link->tcp_open = gn_link_tcp_open(&link->tcp, settings->tcp_port, error, error_size);
        if (!link->tcp_open) {
            gn_link_linux_close(link);
            return NULL;
        }
    }
    return link;
}

void gn_link_linux_close(struct gn_link_linux *link) {
    if (link->usb) {
        gn_link_ffs_close(&link->ffs);
        link->usb = false;
    }
    if (link->tcp_open) {
        gn_link_tcp_close(&link->tcp);
        link->tcp_open = false;
    }
}

static int read_client(void *context, uint32_t client, uint8_t *buffer, size_t capacity) {
    struct gn_link_linux *link = context;
    if (client == USB_CLIENT) {
        return link->usb ? gn_ffs_stream_read(&link->ffs.stream, buffer, capacity) : -1;
    }
    return link->tcp_open ? gn_link_tcp_read(&link->tcp, client - 1u, buffer, capacity) : -1;
}

static int write_client(void *context, uint32_t client, const uint8_t *bytes, size_t length) {
    struct gn_link_linux *link = context;
    if (client == USB_CLIENT) {
        return link->usb ? gn_ffs_stream_write(&link->ffs.stream, bytes, length) : -1;
    }
    return link->tcp_open ? gn_link_tcp_write(&link->tcp, client - 1u, bytes, length) : -1;
}

static void close_client(void *context, uint32_t client) {
    struct gn_link_linux *link = context;
    if (client == USB_CLIENT && link->usb) {
        gn_ffs_stream_dismiss(&link->ffs.stream);
    } else if (client != USB_CLIENT && link->tcp_open) {
        gn_link_tcp_dismiss(&link->tcp, client - 1u);
    }
}

void gn_link_linux_port(struct gn_link_linux *link, struct gn_link_port *port) {
    *port = (struct gn_link_port){.context = link, .read = read_client, .write = write_client, .close = close_client};
}

uint16_t gn_link_linux_tcp_port(const struct gn_link_linux *link) {
    return link->tcp_open ? link->tcp.port : 0u;
}

uint32_t gn_link_linux_polls(const struct gn_link_linux *link, struct pollfd *polls) {
    uint32_t count = 0;
    if (link->usb) {
        count += gn_link_ffs_polls(&link->ffs, polls);
    }
    if (link->tcp_open) {
        count += gn_link_tcp_polls(&link->tcp, polls + count);
    }
    return count;
}

void gn_link_linux_process(struct gn_link_linux *link) {
    if (link->usb) {
        gn_link_ffs_process(&link->ffs);
    }
    if (link->tcp_open) {
        gn_link_tcp_process(&link->tcp);
    }
}
