/* digitiser.h: the seam of the USB digitiser; one call reads one whole packet (protocol/digitiser.md). */
#ifndef GONIO_PORT_DIGITISER_H
#define GONIO_PORT_DIGITISER_H

#include <stddef.h>
#include <stdint.h>

struct gn_digitiser_port {
    void *context;
    int (*start)(void *context, uint32_t sample_period_us, uint32_t samples_per_strobe); /* 0, or -1: not there */
    void (*stop)(void *context);
    /* Bytes of one packet, 0: none waiting, -1: unplugged. */
    int (*read)(void *context, uint8_t *buffer, size_t capacity);
};

#endif
