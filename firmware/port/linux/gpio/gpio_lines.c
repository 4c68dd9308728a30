/* gpio_lines.c: input edges and outputs; an output or a chip that fails ends the watchdog's pulses, which is safe. */
#include "gpio_lines.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "edge_map.h"
#include "gpio_chip.h"

/* Edges taken from the kernel with one call. */
#define READ_AT_ONCE 32u

struct input_chip {
    char path[GN_CHIP_PATH];
    struct gpiod_line_request *request;
    struct gn_edge_map map;
    bool lost;
};

struct output {
    struct gpiod_line_request *request; /* NULL: not wired */
    uint32_t offset;
    bool on;
};

struct gn_gpio_lines {
    struct input_chip chips[GN_LINE_COUNT];
    uint32_t chip_count;
    struct output outputs[GN_GPIO_OUTPUTS];
    bool failed; /* a line does not do what it is told, or a chip is lost */
    struct gpiod_edge_event_buffer *events;
    uint32_t event_count;
    uint32_t event_next;
    uint32_t event_chip; /* where they are from */
};

static const char *const input_names[GN_LINE_COUNT] = {"input.strobe", "input.door", "input.emergency_stop",
                                                       "input.sto", "input.limit"};
static const char *const output_names[GN_GPIO_OUTPUTS] = {"output.shutter", "output.lamp", "output.watchdog"};

static bool place_input(struct gn_gpio_lines *lines, const struct gn_gpio_settings *settings, uint32_t line,
                        char *error, size_t error_size) {
    struct gn_wanted_line const wanted = {input_names[line], &settings->inputs[line]};
    char path[GN_CHIP_PATH];
    uint32_t chip = 0;
    if (!gn_gpio_chip_path(&wanted, path, error, error_size)) {
        return false;
    }
    while (chip < lines->chip_count && strcmp(lines->chips[chip].path, path) != 0) {
        chip++;
    }
    if (chip == lines->chip_count) {
        (void)snprintf(lines->chips[chip].path, GN_CHIP_PATH, "%s", path);
        lines->chip_count++;
    }
    lines->chips[chip].map.has[line] = true;
    lines->chips[chip].map.offsets[line] = wanted.line->offset;
    return true;
}

static bool request_inputs(struct input_chip *chip, const struct gn_gpio_settings *settings, char *error,
                           size_t error_size) {
    struct gn_wanted_line wanted[GN_LINE_COUNT];
    uint32_t count = 0;
    for (uint32_t line = 0; line < GN_LINE_COUNT; line++) {
        if (chip->map.has[line]) {
            wanted[count++] = (struct gn_wanted_line){input_names[line], &settings->inputs[line]};
        }
    }
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t k = 0; k < i; k++) {
            if (wanted[i].line->offset == wanted[k].line->offset) {
                (void)snprintf(error, error_size, "%s and %s name the same line %u of %s", wanted[k].name,
                               wanted[i].name, (unsigned)wanted[i].line->offset, chip->path);
                return false;
            }
        }
    }
    chip->request = gn_gpio_chip_request(chip->path, wanted, count, false, settings->event_buffer, error, error_size);
    return chip->request != NULL;
}

static bool open_inputs(struct gn_gpio_lines *lines, const struct gn_gpio_settings *settings, char *error,
                        size_t error_size) {
    for (uint32_t line = 0; line < GN_LINE_COUNT; line++) {
        if (settings->inputs[line].used && !place_input(lines, settings, line, error, error_size)) {
            return false;
        }
    }
    for (uint32_t i = 0; i < lines->chip_count; i++) {
        if (!request_inputs(&lines->chips[i], settings, error, error_size)) {
            return false;
        }
    }
    return true;
}

static bool open_outputs(struct gn_gpio_lines *lines, const struct gn_gpio_settings *settings, char *error,
                         size_t error_size) {
    for (uint32_t i = 0; i < GN_GPIO_OUTPUTS; i++) {
        struct gn_wanted_line const wanted = {output_names[i], &settings->outputs[i]};
        char path[GN_CHIP_PATH];
        if (!wanted.line->used) {
            continue;
        }
        if (!gn_gpio_chip_path(&wanted, path, error, error_size)) {
            return false;
        }
        lines->outputs[i].offset = wanted.line->offset;
        lines->outputs[i].request = gn_gpio_chip_request(path, &wanted, 1, true, 0, error, error_size);
        if (lines->outputs[i].request == NULL) {
            return false;
        }
    }
    return true;
}

struct gn_gpio_lines *gn_gpio_open(const struct gn_gpio_settings *settings, char *error, size_t error_size) {
    static struct gn_gpio_lines instance;
    struct gn_gpio_lines *lines = &instance;
    *lines = (struct gn_gpio_lines){0};
    lines->events = gpiod_edge_event_buffer_new(READ_AT_ONCE);
    if (lines->events == NULL) {
        (void)snprintf(error, error_size, "no memory for edge events");
        return NULL;
    }
    if (!open_outputs(lines, settings, error, error_size) || !open_inputs(lines, settings, error, error_size)) {
        gn_gpio_close(lines);
        return NULL;
    }
    return lines;
}

static void put(struct gn_gpio_lines *lines, enum gn_gpio_output which, bool on) {
    struct output *output = &lines->outputs[which];
    if (output->request == NULL) {
        return;
    }
    output->on = on;
    enum gpiod_line_value const value = on ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
    if (gpiod_line_request_set_value(output->request, output->offset, value) != 0) {
        lines->failed = true;
    }
}

void gn_gpio_close(struct gn_gpio_lines *lines) {
    for (uint32_t i = 0; i < GN_GPIO_OUTPUTS; i++) {
        put(lines, (enum gn_gpio_output)i, false);
        gpiod_line_request_release(lines->outputs[i].request);
    }
    for (uint32_t i = 0; i < lines->chip_count; i++) {
        gpiod_line_request_release(lines->chips[i].request);
    }
    gpiod_edge_event_buffer_free(lines->events);
    *lines = (struct gn_gpio_lines){0};
}

static void lose(struct gn_gpio_lines *lines, struct input_chip *chip) {
    chip->lost = true;
    lines->failed = true;
}

/* More events into the buffer; false: no chip has any. */
static bool read_events(struct gn_gpio_lines *lines) {
    for (uint32_t i = 0; i < lines->chip_count; i++) {
        struct input_chip *chip = &lines->chips[i];
        if (chip->lost) {
            continue;
        }
        int const count = gpiod_line_request_read_edge_events(chip->request, lines->events, READ_AT_ONCE);
        if (count > 0) {
            lines->event_count = (uint32_t)count;
            lines->event_next = 0;
            lines->event_chip = i;
            return true;
        }
        if (count < 0 && errno != EAGAIN && errno != EINTR) {
            lose(lines, chip);
        }
    }
    return false;
}

static bool take_event(struct gn_gpio_lines *lines, struct gn_edge *edge) {
    struct gpiod_edge_event *event = gpiod_edge_event_buffer_get_event(lines->events, lines->event_next++);
    struct gn_line_event const plain = {
        .offset = gpiod_edge_event_get_line_offset(event),
        .number = (uint32_t)gpiod_edge_event_get_line_seqno(event),
        .rising = gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE,
        .stamp_ns = gpiod_edge_event_get_timestamp_ns(event),
    };
    return gn_edge_map_take(&lines->chips[lines->event_chip].map, &plain, edge);
}

static bool take_loss(struct gn_gpio_lines *lines, struct gn_edge *edge) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    for (uint32_t i = 0; i < lines->chip_count; i++) {
        if (lines->chips[i].lost &&
            gn_edge_map_lose(&lines->chips[i].map, (int64_t)now.tv_sec * 1000000000 + now.tv_nsec, edge)) {
            return true;
        }
    }
    return false;
}

static int port_receive(void *context, struct gn_edge *edge) {
    struct gn_gpio_lines *lines = context;
    do {
        while (lines->event_next < lines->event_count) {
            if (take_event(lines, edge)) {
                return 1;
            }
        }
    } while (read_events(lines));
    return lines->failed && take_loss(lines, edge) ? 1 : 0;
}

static bool port_level(void *context, uint32_t line) {
    struct gn_gpio_lines *lines = context;
    for (uint32_t i = 0; i < lines->chip_count; i++) {
        struct input_chip *chip = &lines->chips[i];
        if (line >= GN_LINE_COUNT || !chip->map.has[line]) {
            continue;
        }
        enum gpiod_line_value const value = gpiod_line_request_get_value(chip->request, chip->map.offsets[line]);
        if (value == GPIOD_LINE_VALUE_ERROR) {
            lose(lines, chip);
        }
        return value == GPIOD_LINE_VALUE_ACTIVE;
    }
    return line != GN_LINE_STROBE; /* not wired */
}

static void port_set(void *context, uint32_t output, bool on) {
    if (output == GN_OUT_SHUTTER) {
        put(context, GN_GPIO_SHUTTER, on);
    } else if (output == GN_OUT_LAMP) {
        put(context, GN_GPIO_LAMP, on);
    }
}

/* The board hears the change, not the level. Without it, it closes the shutter by its spring. */
static void port_pulse_watchdog(void *context) {
    struct gn_gpio_lines *lines = context;
    if (!lines->failed) {
        put(lines, GN_GPIO_WATCHDOG, !lines->outputs[GN_GPIO_WATCHDOG].on);
    }
}

static void port_operator_done(void *context, uint32_t action) {
    (void)context;
    (void)action;
}

void gn_gpio_ports(struct gn_gpio_lines *lines, struct gn_edge_port *edge, struct gn_out_port *out) {
    *edge = (struct gn_edge_port){.context = lines, .receive = port_receive, .level = port_level};
    *out = (struct gn_out_port){
        .context = lines,
        .set = port_set,
        .pulse_watchdog = port_pulse_watchdog,
        .operator_done = port_operator_done,
    };
}

uint32_t gn_gpio_fds(const struct gn_gpio_lines *lines, int fds[GN_GPIO_FDS]) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < lines->chip_count; i++) {
        if (!lines->chips[i].lost) {
            fds[count++] = gpiod_line_request_get_fd(lines->chips[i].request);
        }
    }
    return count;
}
