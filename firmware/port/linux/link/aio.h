/* aio.h: the kernel's asynchronous input and output (io_submit(2)), for a fixed number of transfers. */
#ifndef GONIO_AIO_H
#define GONIO_AIO_H

#include <linux/aio_abi.h>
#include <stdbool.h>
#include <stdint.h>

#define GN_AIO_BLOCKS 16u

struct gn_aio {
    aio_context_t context;
    int event_fd; /* readable: something has completed */
    struct iocb blocks[GN_AIO_BLOCKS];
};

struct gn_aio_transfer {
    uint32_t block;
    int fd;
    bool write;
    uint8_t *bytes;
    uint32_t length;
};

/* false: errno says why. */
bool gn_aio_open(struct gn_aio *aio);
/* What is in flight is called back; waits for it. */
void gn_aio_close(struct gn_aio *aio);
/* The block must not be in flight. */
bool gn_aio_submit(struct gn_aio *aio, const struct gn_aio_transfer *transfer);
/* It completes sooner, with an error if nothing was moved. */
void gn_aio_cancel(struct gn_aio *aio, uint32_t block);
/* Without waiting: 1, the block and its result (bytes, or a negative error); 0: none. */
int gn_aio_next(struct gn_aio *aio, uint32_t *block, int64_t *result);

#endif
