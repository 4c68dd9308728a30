/* usb_find.c: vendor, product, serial, then the interface of the digitiser's class (protocol/digitiser.md). */
#include "usb_find.h"

#include <string.h>

#define DIGITISER_CLASS 0xFFu
#define DIGITISER_SUBCLASS 0x47u
#define DIGITISER_PROTOCOL 0x44u

static bool bulk_in(const struct libusb_interface_descriptor *interface, uint8_t *address) {
    for (uint32_t i = 0; i < interface->bNumEndpoints; ++i) {
        const struct libusb_endpoint_descriptor *endpoint = &interface->endpoint[i];
        if ((endpoint->bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0u &&
            (endpoint->bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) == LIBUSB_ENDPOINT_TRANSFER_TYPE_BULK) {
            *address = endpoint->bEndpointAddress;
            return true;
        }
    }
    return false;
}

static bool is_digitiser(const struct libusb_interface_descriptor *interface) {
    return interface->bInterfaceClass == DIGITISER_CLASS && interface->bInterfaceSubClass == DIGITISER_SUBCLASS &&
           interface->bInterfaceProtocol == DIGITISER_PROTOCOL;
}

static bool interface_of(libusb_device *device, struct gn_usb_interface *found) {
    struct libusb_config_descriptor *configuration = NULL;
    if (libusb_get_active_config_descriptor(device, &configuration) != LIBUSB_SUCCESS) {
        return false;
    }
    bool matches = false;
    for (uint32_t i = 0; i < configuration->bNumInterfaces && !matches; ++i) {
        const struct libusb_interface *interface = &configuration->interface[i];
        if (interface->num_altsetting > 0 && is_digitiser(interface->altsetting)) {
            found->number = interface->altsetting->bInterfaceNumber;
            matches = bulk_in(interface->altsetting, &found->in_endpoint);
        }
    }
    libusb_free_config_descriptor(configuration);
    return matches;
}

static bool has_serial(libusb_device_handle *handle, uint8_t index, const char *serial) {
    if (serial[0] == '\0') {
        return true;
    }
    unsigned char text[128];
    int const length = libusb_get_string_descriptor_ascii(handle, index, text, (int)sizeof text);
    return length >= 0 && strlen(serial) == (size_t)length && memcmp(text, serial, (size_t)length) == 0;
}

static bool claim(libusb_device *device, const struct gn_digitiser_settings *settings, struct gn_usb_interface *found) {
    struct libusb_device_descriptor descriptor;
    if (libusb_get_device_descriptor(device, &descriptor) != LIBUSB_SUCCESS ||
        descriptor.idVendor != settings->vendor_id || descriptor.idProduct != settings->product_id ||
        !interface_of(device, found) || libusb_open(device, &found->handle) != LIBUSB_SUCCESS) {
        return false;
    }
    if (has_serial(found->handle, descriptor.iSerialNumber, settings->serial) &&
        libusb_claim_interface(found->handle, found->number) == LIBUSB_SUCCESS) {
        return true;
    }
    libusb_close(found->handle);
    return false;
}

bool gn_usb_find(libusb_context *context, const struct gn_digitiser_settings *settings,
                 struct gn_usb_interface *found) {
    libusb_device **devices = NULL;
    ssize_t const count = libusb_get_device_list(context, &devices);
    bool claimed = false;
    for (ssize_t i = 0; i < count && !claimed; ++i) {
        claimed = claim(devices[i], settings, found);
    }
    if (count >= 0) {
        libusb_free_device_list(devices, 1);
    }
    return claimed;
}
