/* gpio_lines.h: the seams of input lines and outputs on libgpiod 2; used by the real-time thread alone.
 * Edges are numbered per line by the kernel: the core sees what was lost by the jump. */
#ifndef GONIO_GPIO_LINES_H
#define GONIO_GPIO_LINES_H

#include <stdbool.h>
#include <stddef.h>

#include "edge.h"
#include "out.h"

struct gn_gpio_line {
    bool used;
    bool active_low;
    char chip[64];   /* path of the character device, or the chip's label */
    uint32_t offset; /* on the chip */
};

enum gn_gpio_output { GN_GPIO_SHUTTER = 0, GN_GPIO_LAMP = 1, GN_GPIO_WATCHDOG = 2, GN_GPIO_OUTPUTS = 3 };

struct gn_gpio_settings {
    struct gn_gpio_line inputs[GN_LINE_COUNT]; /* enum gn_line; an unused door, stop, STO or limit line reads high */
    struct gn_gpio_line outputs[GN_GPIO_OUTPUTS];
    uint32_t event_buffer; /* edges that the kernel keeps for us, per line; at most 1024 per chip; 0: its own 16 */
};

#define GN_GPIO_FDS GN_LINE_COUNT

struct gn_gpio_lines; /* one static instance; nothing is allocated after it is open */

/* NULL, and one line in `error` that names line and chip. Outputs begin low (safe). */
struct gn_gpio_lines *gn_gpio_open(const struct gn_gpio_settings *settings, char *error, size_t error_size);
/* Outputs low, lines released. */
void gn_gpio_close(struct gn_gpio_lines *lines);
void gn_gpio_ports(struct gn_gpio_lines *lines, struct gn_edge_port *edge, struct gn_out_port *out);
/* File descriptors to be polled for input, one per chip request; their count. */
uint32_t gn_gpio_fds(const struct gn_gpio_lines *lines, int fds[GN_GPIO_FDS]);
#endif
