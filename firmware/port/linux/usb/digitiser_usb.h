/* digitiser_usb.h: the digitiser's seam on libusb, several transfers in flight; used by the stream thread alone. */
#ifndef GONIO_DIGITISER_USB_H
#define GONIO_DIGITISER_USB_H

#include <poll.h>
#include <stddef.h>

#include "digitiser.h"

struct gn_digitiser_settings {
    uint16_t vendor_id;
    uint16_t product_id;
    char serial[64]; /* empty: any */
};

#define GN_DIGITISER_POLLS 16u

struct gn_digitiser_usb; /* one static instance */

/* NULL, and one line in `error`, only if libusb itself fails: a digitiser that is not there yet is looked for at start.
 */
struct gn_digitiser_usb *gn_digitiser_usb_open(const struct gn_digitiser_settings *settings, char *error,
                                               size_t error_size);
void gn_digitiser_usb_close(struct gn_digitiser_usb *digitiser);
void gn_digitiser_usb_port(struct gn_digitiser_usb *digitiser, struct gn_digitiser_port *port);
/* What to poll besides the rest; their count, at most GN_DIGITISER_POLLS. */
uint32_t gn_digitiser_usb_polls(const struct gn_digitiser_usb *digitiser, struct pollfd *polls);
/* Completes transfers without waiting. Call before each stream_process. */
void gn_digitiser_usb_process(struct gn_digitiser_usb *digitiser);

#endif
