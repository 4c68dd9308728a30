/* gpio_chip.h: finds chips by path, name or label and requests lines of them, with an error that names both. */
#ifndef GONIO_GPIO_CHIP_H
#define GONIO_GPIO_CHIP_H

#include <gpiod.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "gpio_lines.h"

#define GN_CHIP_PATH 80u

struct gn_wanted_line {
    const char *name; /* as in the settings file: input.door */
    const struct gn_gpio_line *line;
};

/* Path of the chip that a setting names; false, and one line in `error`: there is none, or several of that label. */
bool gn_gpio_chip_path(const struct gn_wanted_line *wanted, char path[GN_CHIP_PATH], char *error, size_t error_size);
/* Lines of one chip as inputs with both edges, or as outputs that begin inactive. NULL, and one line in `error`. */
struct gpiod_line_request *gn_gpio_chip_request(const char *path, const struct gn_wanted_line *wanted, uint32_t count,
                                                bool output, uint32_t event_buffer, char *error, size_t error_size);

#endif
