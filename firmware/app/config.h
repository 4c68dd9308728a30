/* config.h: goniod's settings file: `key = value` lines, # begins a comment; an unknown key is an error. */
#ifndef GONIO_CONFIG_H
#define GONIO_CONFIG_H

#include "can_socket.h"
#include "digitiser_usb.h"
#include "gpio_lines.h"
#include "link_linux.h"
#include "threads.h"

struct gn_config {
    char device_name[32];
    struct gn_can_settings can; /* can.interface, can.sync_stamp_sigma_us */
    struct gn_gpio_settings
        gpio; /* input.strobe = gpiochip0:4, input.door = label:5 active-low, output.shutter, gpio.event_buffer */
    struct gn_digitiser_settings digitiser; /* digitiser.usb_id = 1209:0002, digitiser.serial */
    struct gn_link_settings link;           /* link.functionfs, link.tcp_port = 7411 | any | none */
    struct gn_thread_settings threads; /* realtime.motion_priority, realtime.stream_priority, realtime.motion_cpu */
    char watchdog_device[64];          /* watchdog.device, empty: none */
};

/* The defaults of the reference controller. */
void gn_config_defaults(struct gn_config *config);
/* false, and one line in `error`: file, line, what is wrong, what to write. The text need not end in 0. */
bool gn_config_parse(struct gn_config *config, const char *file, const char *text, size_t length, char *error,
                     size_t error_size);
bool gn_config_load(struct gn_config *config, const char *file, char *error, size_t error_size);

#endif
