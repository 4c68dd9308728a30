/* link_ffs.c: endpoint 0 by its events, the bulk endpoints by asynchronous transfers. */
#include "link_ffs.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/usb/functionfs.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "ffs_descriptors.h"

#define REQUEST_OPEN 1u /* protocol/link.md */
#define REQUEST_CLOSE 2u
#define EVENTS_AT_ONCE 4u /* the kernel keeps no more */

_Static_assert(GN_AIO_BLOCKS == GN_FFS_DIRECTIONS * GN_FFS_SLOTS, "one block per slot");

static bool submit(void *context, enum gn_ffs_direction direction, uint32_t slot, uint8_t *bytes, uint32_t length) {
    struct gn_link_ffs *ffs = context;
    struct gn_aio_transfer const transfer = {.block = direction * GN_FFS_SLOTS + slot,
                                             .fd = ffs->endpoints[direction],
                                             .write = direction == GN_FFS_TO_HOST,
                                             .bytes = bytes,
                                             .length = length};
    return gn_aio_submit(&ffs->aio, &transfer);
}

static void cancel(void *context, enum gn_ffs_direction direction, uint32_t slot) {
    struct gn_link_ffs *ffs = context;
    gn_aio_cancel(&ffs->aio, direction * GN_FFS_SLOTS + slot);
}

static int open_file(const char *directory, const char *name, char *error, size_t error_size) {
    char path[160];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    int const fd = open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) {
        (void)snprintf(
            error, error_size,
            "link: cannot open %s: %s; is FunctionFS mounted there, for this user, and no other goniod at it?", path,
            strerror(errno));
    }
    return fd;
}

static bool describe(struct gn_link_ffs *ffs, const char *directory, char *error, size_t error_size) {
    uint8_t bytes[GN_FFS_DESCRIPTORS_MAX];
    size_t length = gn_ffs_descriptors(bytes);
    bool good = write(ffs->ep0, bytes, length) == (ssize_t)length;
    if (good) {
        length = gn_ffs_strings(bytes);
        good = write(ffs->ep0, bytes, length) == (ssize_t)length;
    }
    if (!good) {
        (void)snprintf(error, error_size, "link: FunctionFS at %s refuses the descriptors: %s; is it in use already?",
                       directory, strerror(errno));
    }
    return good;
}

static bool open_all(struct gn_link_ffs *ffs, const char *directory, char *error, size_t error_size) {
    ffs->ep0 = open_file(directory, "ep0", error, error_size);
    if (ffs->ep0 < 0 || !describe(ffs, directory, error, error_size)) {
        return false;
    }
    ffs->endpoints[GN_FFS_TO_HOST] = open_file(directory, "ep1", error, error_size);
    if (ffs->endpoints[GN_FFS_TO_HOST] < 0) {
        return false;
    }
    ffs->endpoints[GN_FFS_FROM_HOST] = open_file(directory, "ep2", error, error_size);
    if (ffs->endpoints[GN_FFS_FROM_HOST] < 0) {
        return false;
    }
    if (!gn_aio_open(&ffs->aio)) {
        (void)snprintf(error, error_size, "link: asynchronous transfers: %s; raise fs.aio-max-nr", strerror(errno));
        return false;
    }
    return true;
}

bool gn_link_ffs_open(struct gn_link_ffs *ffs, const char *directory, char *error, size_t error_size) {
    struct gn_ffs_transfers const transfers = {.context = ffs, .submit = submit, .cancel = cancel};
    ffs->ep0 = -1;
    ffs->endpoints[GN_FFS_TO_HOST] = -1;
    ffs->endpoints[GN_FFS_FROM_HOST] = -1;
    ffs->aio.event_fd = -1;
    ffs->opening = false;
    gn_ffs_stream_init(&ffs->stream, &transfers);
    if (!open_all(ffs, directory, error, error_size)) {
        gn_link_ffs_close(ffs);
        return false;
    }
    return true;
}

static void close_file(int *fd) {
    if (*fd >= 0) {
        (void)close(*fd);
        *fd = -1;
    }
}

void gn_link_ffs_close(struct gn_link_ffs *ffs) {
    gn_aio_close(&ffs->aio);
    close_file(&ffs->endpoints[GN_FFS_TO_HOST]);
    close_file(&ffs->endpoints[GN_FFS_FROM_HOST]);
    close_file(&ffs->ep0);
}

static void take_completed(struct gn_link_ffs *ffs) {
    uint32_t block = 0;
    int64_t result = 0;
    while (gn_aio_next(&ffs->aio, &block, &result) == 1) {
        gn_ffs_stream_complete(&ffs->stream, block < GN_FFS_SLOTS ? GN_FFS_FROM_HOST : GN_FFS_TO_HOST,
                               block % GN_FFS_SLOTS, result);
    }
}

/* FunctionFS answers a request that has no data by an empty read, and refuses it by input or output in the wrong
 * direction. Either waits for the end of the request on the bus, which the host, having asked, is waiting for itself;
 * if it is unplugged meanwhile, the kernel ends the wait. */
static bool acknowledge(struct gn_link_ffs *ffs) {
    return read(ffs->ep0, NULL, 0) == 0;
}

static void refuse(struct gn_link_ffs *ffs, bool to_host) {
    (void)!(to_host ? read(ffs->ep0, NULL, 0) : write(ffs->ep0, NULL, 0));
}

static void answer(struct gn_link_ffs *ffs, const struct usb_ctrlrequest *request) {
    uint8_t const link_request = USB_DIR_OUT | USB_TYPE_VENDOR | USB_RECIP_INTERFACE;
    bool const known = request->bRequestType == link_request && request->wLength == 0u;
    if (known && request->bRequest == REQUEST_OPEN) {
        gn_ffs_stream_end(&ffs->stream, true);
        ffs->opening = true;
    } else if (known && request->bRequest == REQUEST_CLOSE) {
        gn_ffs_stream_end(&ffs->stream, false);
        (void)acknowledge(ffs);
    } else {
        refuse(ffs, (request->bRequestType & USB_DIR_IN) != 0u);
    }
}

static void handle(struct gn_link_ffs *ffs, const struct usb_functionfs_event *event) {
    switch (event->type) {
    case FUNCTIONFS_SETUP:
        answer(ffs, &event->u.setup);
        break;
    case FUNCTIONFS_UNBIND:
    case FUNCTIONFS_DISABLE:
    case FUNCTIONFS_SUSPEND: /* the host sleeps, or the cable is out */
    case FUNCTIONFS_ENABLE:  /* the kernel keeps only the newest of these: there may have been a DISABLE before it */
        gn_ffs_stream_end(&ffs->stream, false);
        break;
    default: /* BIND and RESUME: the client comes with OPEN */
        break;
    }
}

static void finish_opening(struct gn_link_ffs *ffs) {
    ffs->opening = false;
    /* What the controller's own buffers hold is of the client before; a controller without such buffers refuses. */
    (void)ioctl(ffs->endpoints[GN_FFS_TO_HOST], FUNCTIONFS_FIFO_FLUSH);
    (void)ioctl(ffs->endpoints[GN_FFS_FROM_HOST], FUNCTIONFS_FIFO_FLUSH);
    gn_ffs_stream_begin(&ffs->stream);
    if (!ffs->stream.open) {
        refuse(ffs, false); /* the endpoints take no transfers */
    } else if (!acknowledge(ffs)) {
        gn_ffs_stream_end(&ffs->stream, true); /* the host has given up, or asked anew */
    }
}

/* A request that waits for its answer is the last event that the kernel hands out; while OPEN waits, a read would
 * answer it. */
static void take_events(struct gn_link_ffs *ffs) {
    struct usb_functionfs_event events[EVENTS_AT_ONCE];
    while (!ffs->opening) {
        ssize_t const length = read(ffs->ep0, events, sizeof events);
        if (length < 0 && errno == EIDRM) {
            continue; /* the request was withdrawn; what came instead follows */
        }
        if (length < (ssize_t)sizeof events[0]) {
            return;
        }
        for (size_t i = 0; i < (size_t)length / sizeof events[0]; ++i) {
            handle(ffs, &events[i]);
        }
    }
}

void gn_link_ffs_process(struct gn_link_ffs *ffs) {
    take_completed(ffs);
    take_events(ffs);
    if (ffs->opening) {
        take_completed(ffs);
        if (gn_ffs_stream_idle(&ffs->stream)) {
            finish_opening(ffs);
        }
    }
}

uint32_t gn_link_ffs_polls(const struct gn_link_ffs *ffs, struct pollfd *polls) {
    uint32_t count = 0;
    polls[count++] = (struct pollfd){.fd = ffs->aio.event_fd, .events = POLLIN};
    if (!ffs->opening) {
        polls[count++] = (struct pollfd){.fd = ffs->ep0, .events = POLLIN};
    }
    return count;
}
