/* aio.c: raw system calls: glibc has no wrappers, and libaio would add nothing. */
#include "aio.h"

#include <string.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <unistd.h>

bool gn_aio_open(struct gn_aio *aio) {
    memset(aio, 0, sizeof *aio);
    aio->event_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (aio->event_fd < 0) {
        return false;
    }
    if (syscall(SYS_io_setup, GN_AIO_BLOCKS, &aio->context) != 0) {
        (void)close(aio->event_fd);
        aio->event_fd = -1;
        return false;
    }
    return true;
}

void gn_aio_close(struct gn_aio *aio) {
    if (aio->event_fd >= 0) {
        (void)syscall(SYS_io_destroy, aio->context);
        (void)close(aio->event_fd);
        aio->event_fd = -1;
    }
}

bool gn_aio_submit(struct gn_aio *aio, const struct gn_aio_transfer *transfer) {
    struct iocb *block = &aio->blocks[transfer->block];
    memset(block, 0, sizeof *block);
    block->aio_data = transfer->block;
    block->aio_lio_opcode = transfer->write ? IOCB_CMD_PWRITE : IOCB_CMD_PREAD;
    block->aio_fildes = (uint32_t)transfer->fd;
    block->aio_buf = (uint64_t)(uintptr_t)transfer->bytes;
    block->aio_nbytes = transfer->length;
    block->aio_flags = IOCB_FLAG_RESFD;
    block->aio_resfd = (uint32_t)aio->event_fd;
    return syscall(SYS_io_submit, aio->context, 1L, &block) == 1;
}

void gn_aio_cancel(struct gn_aio *aio, uint32_t block) {
    struct io_event unused; /* kernels since 4.19 report a cancelled transfer only among the completed ones */
    (void)syscall(SYS_io_cancel, aio->context, &aio->blocks[block], &unused);
}

int gn_aio_next(struct gn_aio *aio, uint32_t *block, int64_t *result) {
    struct io_event event;
    /* At least 0 events: no waiting, whatever the time-out. */
    if (syscall(SYS_io_getevents, aio->context, 0L, 1L, &event, NULL) != 1) {
        uint64_t count = 0;
        (void)!read(aio->event_fd, &count, sizeof count);
        /* One that completed between the two calls would wake nobody. */
        if (syscall(SYS_io_getevents, aio->context, 0L, 1L, &event, NULL) != 1) {
            return 0;
        }
    }
    *block = (uint32_t)event.data;
    *result = event.res;
    return 1;
}
