/* link_ffs.h: the client on USB: this controller is a gadget, its interface is served through FunctionFS. The gadget
 * itself (configfs) and the mount are made by the set-up before, and bound to the port after. */
#ifndef GONIO_LINK_FFS_H
#define GONIO_LINK_FFS_H

#include <poll.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "aio.h"
#include "ffs_stream.h"

#define GN_FFS_POLLS 2u

struct gn_link_ffs {
    int ep0;
    int endpoints[GN_FFS_DIRECTIONS];
    bool opening; /* OPEN came; it is answered when the transfers of the client before are back */
    struct gn_aio aio;
    struct gn_ffs_stream stream;
};

/* Writes the descriptors. false, and one line in `error`. */
bool gn_link_ffs_open(struct gn_link_ffs *ffs, const char *directory, char *error, size_t error_size);
/* The kernel takes the gadget off the port: the host sees an unplug. */
void gn_link_ffs_close(struct gn_link_ffs *ffs);
/* Completes transfers, answers requests and events; the client's bytes are in `stream`. */
void gn_link_ffs_process(struct gn_link_ffs *ffs);
/* At most GN_FFS_POLLS. */
uint32_t gn_link_ffs_polls(const struct gn_link_ffs *ffs, struct pollfd *polls);

#endif
