/* usb_find.h: finds the digitiser among the USB devices and takes its interface. */
#ifndef GONIO_USB_FIND_H
#define GONIO_USB_FIND_H

#include <libusb.h>
#include <stdbool.h>
#include <stdint.h>

#include "digitiser_usb.h"

struct gn_usb_interface {
    libusb_device_handle *handle;
    uint8_t number;
    uint8_t in_endpoint;
};

/* Opened and claimed. false: not there, or it cannot be opened. */
bool gn_usb_find(libusb_context *context, const struct gn_digitiser_settings *settings, struct gn_usb_interface *found);

#endif
