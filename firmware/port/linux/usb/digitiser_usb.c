/* digitiser_usb.c: attaches to the digitiser at START, keeps its transfers in flight, notices that it went. */
#include "digitiser_usb.h"

#include <libusb.h>
#include <stdio.h>
#include <string.h>

#include "packet_queue.h"
#include "usb_find.h"

#define REQUEST_START 1u
#define REQUEST_STOP 2u
/* The digitiser answers its two requests within a frame or two; START and STOP come once per acquisition and the
 * stream thread may wait for them: motion has a thread of its own, and the link's buffers hold much longer. */
#define REQUEST_TIMEOUT_MS 250u
#define CANCEL_TIMEOUT_MS 250 /* cancelled transfers come back with the next interrupt of the host controller */

#define SWEEP_TIMEOUT_MS 10u /* what waits in the digitiser comes with the next USB frames, of 1 ms */

struct gn_digitiser_usb {
    struct gn_digitiser_settings settings;
    libusb_context *context; /* lives as long as the device is attached: a new one sees what is plugged in now */
    struct gn_usb_interface device;
    struct libusb_transfer *transfers[GN_PACKET_SLOTS]; /* of this context: libusb keeps the device in them */
    struct gn_packet_queue queue;
    struct pollfd polls[GN_DIGITISER_POLLS];
    uint32_t poll_count;
};

static void LIBUSB_CALL poll_added(int fd, short events, void *user_data) {
    struct gn_digitiser_usb *digitiser = user_data;
    if (digitiser->poll_count < GN_DIGITISER_POLLS) {
        digitiser->polls[digitiser->poll_count++] = (struct pollfd){.fd = fd, .events = events};
    }
}

static void LIBUSB_CALL poll_removed(int fd, void *user_data) {
    struct gn_digitiser_usb *digitiser = user_data;
    for (uint32_t i = 0; i < digitiser->poll_count; ++i) {
        if (digitiser->polls[i].fd == fd) {
            digitiser->polls[i] = digitiser->polls[--digitiser->poll_count];
            return;
        }
    }
}

static void note_polls(struct gn_digitiser_usb *digitiser) {
    digitiser->poll_count = 0;
    const struct libusb_pollfd **list = libusb_get_pollfds(digitiser->context);
    for (uint32_t i = 0; list != NULL && list[i] != NULL; ++i) {
        poll_added(list[i]->fd, list[i]->events, digitiser);
    }
    libusb_free_pollfds(list);
    libusb_set_pollfd_notifiers(digitiser->context, poll_added, poll_removed, digitiser);
}

static void LIBUSB_CALL transfer_done(struct libusb_transfer *transfer) {
    struct gn_digitiser_usb *digitiser = transfer->user_data;
    uint32_t const slot = (uint32_t)((transfer->buffer - digitiser->queue.bytes[0]) / GN_PACKET_SLOT_BYTES);
    if (transfer->status == LIBUSB_TRANSFER_COMPLETED) {
        gn_packet_queue_complete(&digitiser->queue, slot, (uint32_t)transfer->actual_length);
    } else {
        /* After a failed transfer the bus has given up three times, or the cable is out: what would come next cannot
         * be told apart from what was lost, so the acquisition ends. */
        gn_packet_queue_fail(&digitiser->queue, slot);
    }
}

static bool submit(void *context, uint32_t slot) {
    struct gn_digitiser_usb *digitiser = context;
    struct libusb_transfer *transfer = digitiser->transfers[slot];
    libusb_fill_bulk_transfer(transfer, digitiser->device.handle, digitiser->device.in_endpoint,
                              digitiser->queue.bytes[slot], (int)GN_PACKET_SLOT_BYTES, transfer_done, digitiser, 0);
    return libusb_submit_transfer(transfer) == LIBUSB_SUCCESS;
}

static void handle_events(struct gn_digitiser_usb *digitiser) {
    struct timeval none = {0, 0};
    (void)libusb_handle_events_timeout_completed(digitiser->context, &none, NULL);
}

static void cancel(struct gn_digitiser_usb *digitiser) {
    digitiser->queue.gone = true; /* nothing is submitted meanwhile */
    for (uint32_t slot = 0; slot < GN_PACKET_SLOTS; ++slot) {
        if (digitiser->queue.slots[slot] == GN_PACKET_IN_FLIGHT) {
            (void)libusb_cancel_transfer(digitiser->transfers[slot]);
        }
    }
}

/* false: transfers are still out. */
static bool call_back(struct gn_digitiser_usb *digitiser) {
    cancel(digitiser);
    for (int waited_ms = 0; digitiser->queue.in_flight > 0u && waited_ms < CANCEL_TIMEOUT_MS; ++waited_ms) {
        struct timeval step = {0, 1000};
        (void)libusb_handle_events_timeout_completed(digitiser->context, &step, NULL);
    }
    return digitiser->queue.in_flight == 0u;
}

static bool allocate(struct gn_digitiser_usb *digitiser) {
    bool complete = true;
    for (uint32_t slot = 0; slot < GN_PACKET_SLOTS; ++slot) {
        digitiser->transfers[slot] = libusb_alloc_transfer(0);
        complete = complete && digitiser->transfers[slot] != NULL;
    }
    return complete;
}

static void detach(struct gn_digitiser_usb *digitiser) {
    for (uint32_t slot = 0; slot < GN_PACKET_SLOTS; ++slot) {
        libusb_free_transfer(digitiser->transfers[slot]);
        digitiser->transfers[slot] = NULL;
    }
    if (digitiser->device.handle != NULL) {
        (void)libusb_release_interface(digitiser->device.handle, digitiser->device.number);
        libusb_close(digitiser->device.handle);
        digitiser->device.handle = NULL;
    }
    if (digitiser->context != NULL) {
        libusb_set_pollfd_notifiers(digitiser->context, NULL, NULL, NULL);
        libusb_exit(digitiser->context);
        digitiser->context = NULL;
        digitiser->poll_count = 0;
    }
}

static bool request(struct gn_digitiser_usb *digitiser, uint8_t number, uint8_t *data, uint16_t length) {
    int const sent = libusb_control_transfer(digitiser->device.handle,
                                             (uint8_t)LIBUSB_ENDPOINT_OUT | (uint8_t)LIBUSB_REQUEST_TYPE_VENDOR |
                                                 (uint8_t)LIBUSB_RECIPIENT_INTERFACE,
                                             number, 0, digitiser->device.number, data, length, REQUEST_TIMEOUT_MS);
    return sent == (int)length;
}

/* A reader that died may have left the digitiser running, and a packet in its USB controller, where START cannot drop
 * it: its numbers would pass for a gap. */
static void sweep(struct gn_digitiser_usb *digitiser) {
    int length = 0;
    int status = LIBUSB_SUCCESS;
    (void)request(digitiser, REQUEST_STOP, NULL, 0);
    for (uint32_t i = 0; i < GN_PACKET_SLOTS && status == LIBUSB_SUCCESS; ++i) {
        status = libusb_bulk_transfer(digitiser->device.handle, digitiser->device.in_endpoint,
                                      digitiser->queue.bytes[0], (int)GN_PACKET_SLOT_BYTES, &length, SWEEP_TIMEOUT_MS);
    }
}

static bool attach(struct gn_digitiser_usb *digitiser) {
    if (libusb_init(&digitiser->context) != LIBUSB_SUCCESS) {
        digitiser->context = NULL;
        return false;
    }
    if (!gn_usb_find(digitiser->context, &digitiser->settings, &digitiser->device)) {
        digitiser->device.handle = NULL;
        detach(digitiser);
        return false;
    }
    if (!allocate(digitiser)) {
        detach(digitiser);
        return false;
    }
    note_polls(digitiser);
    sweep(digitiser);
    return true;
}

static void put_u32(uint8_t *bytes, uint32_t value) {
    for (uint32_t i = 0; i < 4u; ++i) {
        bytes[i] = (uint8_t)(value >> (8u * i));
    }
}

static bool begin(struct gn_digitiser_usb *digitiser, uint32_t sample_period_us, uint32_t samples_per_strobe) {
    uint8_t data[8];
    put_u32(data, sample_period_us);
    put_u32(data + 4, samples_per_strobe);
    return call_back(digitiser) && request(digitiser, REQUEST_START, data, sizeof data) &&
           gn_packet_queue_start(&digitiser->queue);
}

static int start(void *context, uint32_t sample_period_us, uint32_t samples_per_strobe) {
    struct gn_digitiser_usb *digitiser = context;
    if (digitiser->device.handle != NULL && begin(digitiser, sample_period_us, samples_per_strobe)) {
        return 0;
    }
    /* It is gone, or it was replugged since: whatever answers to the ids now is looked for once. */
    if (digitiser->context != NULL && !call_back(digitiser)) {
        return -1;
    }
    detach(digitiser);
    if (attach(digitiser) && begin(digitiser, sample_period_us, samples_per_strobe)) {
        return 0;
    }
    if (digitiser->context != NULL && call_back(digitiser)) {
        detach(digitiser);
    }
    return -1;
}

static void stop(void *context) {
    struct gn_digitiser_usb *digitiser = context;
    if (digitiser->device.handle != NULL) {
        (void)request(digitiser, REQUEST_STOP, NULL, 0);
        handle_events(digitiser); /* what was sent before STOP is complete: the core reads it now */
    }
}

static int read_packet(void *context, uint8_t *buffer, size_t capacity) {
    struct gn_digitiser_usb *digitiser = context;
    return gn_packet_queue_read(&digitiser->queue, buffer, capacity);
}

struct gn_digitiser_usb *gn_digitiser_usb_open(const struct gn_digitiser_settings *settings, char *error,
                                               size_t error_size) {
    static struct gn_digitiser_usb the_digitiser;
    struct gn_digitiser_usb *digitiser = &the_digitiser;
    memset(digitiser, 0, sizeof *digitiser);
    digitiser->settings = *settings;
    gn_packet_queue_init(&digitiser->queue, submit, digitiser);
    int const status = libusb_init(&digitiser->context);
    if (status != LIBUSB_SUCCESS) {
        (void)snprintf(error, error_size, "digitiser: libusb cannot start: %s; is /dev/bus/usb there and readable?",
                       libusb_strerror(status));
        return NULL;
    }
    detach(digitiser);
    return digitiser;
}

void gn_digitiser_usb_close(struct gn_digitiser_usb *digitiser) {
    stop(digitiser);
    /* Transfers that do not come back stay with the kernel, and so must their buffers, which are static. */
    if (digitiser->context != NULL && call_back(digitiser)) {
        detach(digitiser);
    }
}

void gn_digitiser_usb_port(struct gn_digitiser_usb *digitiser, struct gn_digitiser_port *port) {
    *port = (struct gn_digitiser_port){.context = digitiser, .start = start, .stop = stop, .read = read_packet};
}

uint32_t gn_digitiser_usb_polls(const struct gn_digitiser_usb *digitiser, struct pollfd *polls) {
    memcpy(polls, digitiser->polls, digitiser->poll_count * sizeof *polls);
    return digitiser->poll_count;
}

void gn_digitiser_usb_process(struct gn_digitiser_usb *digitiser) {
    if (digitiser->context == NULL) {
        return;
    }
    handle_events(digitiser);
    if (!digitiser->queue.gone) {
        return;
    }
    cancel(digitiser);
    /* The file of a device that is gone stays readable and would keep the thread awake. Packets remain to be read. */
    if (digitiser->queue.in_flight == 0u) {
        detach(digitiser);
    }
}
