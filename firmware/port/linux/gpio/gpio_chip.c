/* gpio_chip.c: the part of libgpiod that allocates; it runs at start only. */
#include "gpio_chip.h"

#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <stdio.h>
#include <string.h>

/* The kernel keeps no more edges than this per request (GPIO_V2_LINES_MAX * 16). */
#define KERNEL_EVENTS 1024u

static bool has_label(const char *path, const char *label) {
    bool found = false;
    struct gpiod_chip *chip = gpiod_chip_open(path);
    struct gpiod_chip_info *info = chip == NULL ? NULL : gpiod_chip_get_info(chip);
    if (info != NULL) {
        found = strcmp(gpiod_chip_info_get_label(info), label) == 0;
        gpiod_chip_info_free(info);
    }
    if (chip != NULL) {
        gpiod_chip_close(chip);
    }
    return found;
}

static uint32_t find_by_label(const char *label, char path[GN_CHIP_PATH]) {
    uint32_t found = 0;
    glob_t devices;
    if (glob("/dev/gpiochip*", 0, NULL, &devices) != 0) {
        return 0;
    }
    for (size_t i = 0; i < devices.gl_pathc; i++) {
        if (has_label(devices.gl_pathv[i], label)) {
            (void)snprintf(path, GN_CHIP_PATH, "%s", devices.gl_pathv[i]);
            found++;
        }
    }
    globfree(&devices);
    return found;
}

bool gn_gpio_chip_path(const struct gn_wanted_line *wanted, char path[GN_CHIP_PATH], char *error, size_t error_size) {
    const char *chip = wanted->line->chip;
    (void)snprintf(path, GN_CHIP_PATH, "%s%s", strchr(chip, '/') != NULL ? "" : "/dev/", chip);
    if (gpiod_is_gpiochip_device(path)) {
        return true;
    }
    uint32_t const found = find_by_label(chip, path);
    if (found != 1u) {
        (void)snprintf(error, error_size, "%s: %s GPIO chip has the path, name or label %s; see gpiodetect",
                       wanted->name, found == 0u ? "no" : "more than one", chip);
    }
    return found == 1u;
}

static const char *why_not(int number) {
    switch (number) {
    case EBUSY:
        return "another program holds it";
    case EACCES:
    case EPERM:
        return "no right to use it: run goniod as its service does, or join the device's group";
    case ENXIO:
        return "it gives no interrupts: wire the input to a line that does";
    default:
        return strerror(number);
    }
}

/* Which of the lines cannot be had, and why; the request itself does not say which. */
static bool usable(struct gpiod_chip *chip, const char *path, const struct gn_wanted_line *wanted, char *error,
                   size_t error_size) {
    unsigned const offset = wanted->line->offset;
    struct gpiod_line_info *info = gpiod_chip_get_line_info(chip, offset);
    if (info == NULL) {
        (void)snprintf(error, error_size, "%s: %s has no line %u; see gpioinfo", wanted->name, path, offset);
        return false;
    }
    bool const used = gpiod_line_info_is_used(info);
    if (used) {
        const char *consumer = gpiod_line_info_get_consumer(info);
        (void)snprintf(error, error_size, "%s: line %u of %s is in use by %s: end that, or wire another line",
                       wanted->name, offset, path, consumer != NULL ? consumer : "the kernel");
    }
    gpiod_line_info_free(info);
    return !used;
}

static bool add_line(struct gpiod_line_config *config, struct gpiod_line_settings *settings,
                     const struct gn_wanted_line *wanted, bool output) {
    unsigned const offset = wanted->line->offset;
    gpiod_line_settings_reset(settings);
    gpiod_line_settings_set_active_low(settings, wanted->line->active_low);
    if (output) {
        (void)gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT);
        (void)gpiod_line_settings_set_output_value(settings, GPIOD_LINE_VALUE_INACTIVE);
    } else {
        (void)gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_INPUT);
        (void)gpiod_line_settings_set_edge_detection(settings, GPIOD_LINE_EDGE_BOTH);
        (void)gpiod_line_settings_set_event_clock(settings, GPIOD_LINE_CLOCK_MONOTONIC);
    }
    return gpiod_line_config_add_line_settings(config, &offset, 1, settings) == 0;
}

static struct gpiod_line_request *request_of(struct gpiod_chip *chip, const struct gn_wanted_line *wanted,
                                             uint32_t count, bool output, uint32_t event_buffer) {
    struct gpiod_line_request *request = NULL;
    struct gpiod_line_config *lines = gpiod_line_config_new();
    struct gpiod_line_settings *settings = gpiod_line_settings_new();
    struct gpiod_request_config *config = gpiod_request_config_new();
    bool good = lines != NULL && settings != NULL && config != NULL;
    for (uint32_t i = 0; good && i < count; i++) {
        good = add_line(lines, settings, &wanted[i], output);
    }
    if (good) {
        uint64_t const events = (uint64_t)event_buffer * count;
        gpiod_request_config_set_consumer(config, "goniod");
        gpiod_request_config_set_event_buffer_size(config, events < KERNEL_EVENTS ? (size_t)events : KERNEL_EVENTS);
        request = gpiod_chip_request_lines(chip, config, lines);
    }
    int const why = errno;
    gpiod_request_config_free(config);
    gpiod_line_settings_free(settings);
    gpiod_line_config_free(lines);
    errno = why;
    return request;
}

struct gpiod_line_request *gn_gpio_chip_request(const char *path, const struct gn_wanted_line *wanted, uint32_t count,
                                                bool output, uint32_t event_buffer, char *error, size_t error_size) {
    struct gpiod_line_request *request = NULL;
    struct gpiod_chip *chip = gpiod_chip_open(path);
    bool good = chip != NULL;
    if (!good) {
        (void)snprintf(error, error_size, "%s: %s: %s", wanted->name, path, why_not(errno));
    }
    for (uint32_t i = 0; good && i < count; i++) {
        good = usable(chip, path, &wanted[i], error, error_size);
    }
    if (good) {
        request = request_of(chip, wanted, count, output, event_buffer);
        if (request == NULL) {
            (void)snprintf(error, error_size, "%s (line %u of %s): %s", wanted->name, (unsigned)wanted->line->offset,
                           path, why_not(errno));
        }
    }
    if (chip != NULL) {
        gpiod_chip_close(chip);
    }
    if (request != NULL && !output) { /* reading never waits */
        int const fd = gpiod_line_request_get_fd(request);
        (void)fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
    }
    return request;
}
