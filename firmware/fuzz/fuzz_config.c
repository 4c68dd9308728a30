/* fuzz_config.c: any bytes as a settings file: taken with every value in its range, or refused with one printable line.
 */
#include <stdlib.h>
#include <string.h>

#include "config.h"

static void require(bool holds) {
    if (!holds) {
        abort();
    }
}

static void require_text(const char *text, size_t size) {
    require(memchr(text, 0, size) != NULL);
}

static void require_good(const struct gn_config *config) {
    require_text(config->device_name, sizeof config->device_name);
    require(config->device_name[0] != '\0');
    require_text(config->can.interface, sizeof config->can.interface);
    require(config->can.interface[0] != '\0');
    require(config->can.sync_stamp_sigma_us >= 0.0f && config->can.sync_stamp_sigma_us <= 10000.0f);
    for (int i = 0; i < GN_LINE_COUNT; ++i) {
        require_text(config->gpio.inputs[i].chip, sizeof config->gpio.inputs[i].chip);
        require(!config->gpio.inputs[i].used || config->gpio.inputs[i].chip[0] != '\0');
    }
    for (int i = 0; i < GN_GPIO_OUTPUTS; ++i) {
        require_text(config->gpio.outputs[i].chip, sizeof config->gpio.outputs[i].chip);
        require(!config->gpio.outputs[i].used || config->gpio.outputs[i].chip[0] != '\0');
    }
    require(config->gpio.event_buffer >= 16u && config->gpio.event_buffer <= 1024u);
    require_text(config->digitiser.serial, sizeof config->digitiser.serial);
    require_text(config->link.functionfs, sizeof config->link.functionfs);
    require(config->link.tcp || config->link.functionfs[0] == '/');
    require(config->threads.motion_priority >= 0 && config->threads.motion_priority <= 98);
    require(config->threads.stream_priority >= 0 && config->threads.stream_priority <= 98);
    require(config->threads.motion_cpu >= -1 && config->threads.motion_cpu <= 1023);
    require_text(config->watchdog_device, sizeof config->watchdog_device);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct gn_config config;
    char error[256] = "";
    gn_config_defaults(&config);
    if (gn_config_parse(&config, "fuzz.conf", (const char *)data, size, error, sizeof error)) {
        require_good(&config);
        return 0;
    }
    require_text(error, sizeof error);
    require(strncmp(error, "fuzz.conf:", 10) == 0);
    for (const char *letter = error; *letter != '\0'; ++letter) {
        require(*letter >= ' ' && *letter <= '~');
    }
    return 0;
}
