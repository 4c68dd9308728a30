/* config.c: the settings file: lines of `key = value`; an unknown or repeated key is an error, so that no setting is
 * lost by a slip of the pen. */
#include "config.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "config_values.h"

#define VALUE_SIZE 128u
#define FILE_SIZE_MAX 65536u /* the commented default file has 4 kB */

#define PLACE(member) offsetof(struct gn_config, member), sizeof(((struct gn_config *)0)->member)
#define LINE_RULE "write CHIP:OFFSET, e.g. gpiochip0:4, with active-low behind it where the wire is inverted, or none"
#define INPUT(name, line)                                                                                              \
    { name, gn_config_read_line, PLACE(gpio.inputs[line]), 0, 0, "none", LINE_RULE }
#define OUTPUT(name, line)                                                                                             \
    { name, gn_config_read_line, PLACE(gpio.outputs[line]), 0, 0, "none", LINE_RULE }
#define PRIORITY_RULE "write 1 to 98, or 0 to leave the scheduling as it is"

static const struct gn_config_key keys[] = {
    {"device.name", gn_config_read_word, PLACE(device_name), 0, 0, NULL,
     "write up to 31 letters, digits, dots and dashes"},
    {"can.interface", gn_config_read_word, PLACE(can.interface), 0, 0, NULL, "write an interface's name, e.g. can0"},
    {"can.sync_stamp_sigma_us", gn_config_read_float, PLACE(can.sync_stamp_sigma_us), 0, 10000, NULL,
     "write microseconds, 0 to 10000"},
    INPUT("input.strobe", GN_LINE_STROBE),
    INPUT("input.door", GN_LINE_DOOR),
    INPUT("input.emergency_stop", GN_LINE_EMERGENCY_STOP),
    INPUT("input.sto", GN_LINE_STO),
    INPUT("input.limit", GN_LINE_LIMIT),
    OUTPUT("output.shutter", GN_GPIO_SHUTTER),
    OUTPUT("output.lamp", GN_GPIO_LAMP),
    OUTPUT("output.watchdog", GN_GPIO_WATCHDOG),
    {"gpio.event_buffer", gn_config_read_count, PLACE(gpio.event_buffer), 16, 1024, NULL,
     "write a number of edges, 16 to 1024"},
    {"digitiser.usb_id", gn_config_read_usb, PLACE(digitiser), 0, 0, NULL,
     "write VENDOR:PRODUCT in hexadecimal digits, e.g. 1209:0002"},
    {"digitiser.serial", gn_config_read_word, PLACE(digitiser.serial), 0, 0, "any", "write a serial number, or any"},
    {"link.functionfs", gn_config_read_path, PLACE(link.functionfs), 0, 0, "none",
     "write the absolute path where FunctionFS is mounted, or none"},
    {"link.tcp_port", gn_config_read_port, PLACE(link), 1, 65535, "none", "write a port, 1 to 65535, or any, or none"},
    {"realtime.motion_priority", gn_config_read_int, PLACE(threads.motion_priority), 0, 98, NULL, PRIORITY_RULE},
    {"realtime.stream_priority", gn_config_read_int, PLACE(threads.stream_priority), 0, 98, NULL, PRIORITY_RULE},
    {"realtime.motion_cpu", gn_config_read_cpu, PLACE(threads.motion_cpu), 0, 1023, "any",
     "write a processor's number from 0, or any"},
    {"watchdog.device", gn_config_read_path, PLACE(watchdog_device), 0, 0, "none",
     "write a path such as /dev/watchdog, or none"},
};
#define KEY_COUNT (sizeof keys / sizeof keys[0])

/* Where the parser stands, and where it complains. */
struct parser {
    struct gn_config *config;
    const char *file;
    uint32_t line;
    uint32_t given_at[KEY_COUNT]; /* line of each key; 0: not given */
    char *error;
    size_t error_size;
};

/* What stood in the file, short and printable, for an error line. */
struct excerpt {
    char text[41];
};

static struct excerpt excerpt_of(const char *text, size_t length) {
    struct excerpt excerpt;
    size_t const shown = length < sizeof excerpt.text - 1u ? length : sizeof excerpt.text - 1u;
    for (size_t i = 0; i < shown; ++i) {
        excerpt.text[i] = text[i] >= ' ' && text[i] <= '~' ? text[i] : '?';
    }
    excerpt.text[shown] = '\0';
    return excerpt;
}

/* `before` and `after` stand around what is quoted. */
static bool complain(struct parser *parser, const char *before, const char *quoted, size_t length, const char *after) {
    (void)snprintf(parser->error, parser->error_size, "%s:%u: %s%s%s", parser->file, (unsigned)parser->line, before,
                   excerpt_of(quoted, length).text, after);
    return false;
}

static bool is_blank(char letter) {
    return letter == ' ' || letter == '\t' || letter == '\r';
}

static void trim(const char **text, size_t *length) {
    while (*length > 0u && is_blank(**text)) {
        ++*text;
        --*length;
    }
    while (*length > 0u && is_blank((*text)[*length - 1u])) {
        --*length;
    }
}

static bool set(struct parser *parser, size_t number, const char *value, size_t length) {
    const struct gn_config_key *key = &keys[number];
    char what[160];
    if (parser->given_at[number] != 0u) {
        (void)snprintf(what, sizeof what, " stands in line %u already; keep one of them",
                       (unsigned)parser->given_at[number]);
        return complain(parser, "", key->name, strlen(key->name), what);
    }
    parser->given_at[number] = parser->line;
    char copy[VALUE_SIZE] = "";
    bool good = length < sizeof copy && memchr(value, 0, length) == NULL;
    if (good) {
        memcpy(copy, value, length);
        good = key->read(key, copy, (char *)parser->config + key->offset);
    }
    if (!good) {
        char before[64];
        (void)snprintf(before, sizeof before, "%s: cannot use '", key->name);
        (void)snprintf(what, sizeof what, "'; %s", key->rule);
        return complain(parser, before, value, length, what);
    }
    return true;
}

static bool parse_line(struct parser *parser, const char *text, size_t length) {
    const char *comment = memchr(text, '#', length);
    if (comment != NULL) {
        length = (size_t)(comment - text);
    }
    trim(&text, &length);
    if (length == 0u) {
        return true;
    }
    const char *equals = memchr(text, '=', length);
    if (equals == NULL) {
        return complain(parser, "'", text, length, "' is no setting; write key = value");
    }
    const char *value = equals + 1;
    size_t value_length = length - (size_t)(value - text);
    size_t name_length = (size_t)(equals - text);
    trim(&text, &name_length);
    trim(&value, &value_length);
    for (size_t i = 0; i < KEY_COUNT; ++i) {
        if (strlen(keys[i].name) == name_length && memcmp(keys[i].name, text, name_length) == 0) {
            return set(parser, i, value, value_length);
        }
    }
    return complain(parser, "no setting is called '", text, name_length, "'; docs/controller.md lists them");
}

void gn_config_defaults(struct gn_config *config) {
    *config = (struct gn_config){
        .device_name = "gonio",
        .can = {.interface = "can0", .sync_stamp_sigma_us = 20.0f},
        .gpio = {.event_buffer = 256},
        .digitiser = {.vendor_id = 0x1209, .product_id = 0x0002},
        .link = {.tcp_port = 7411, .tcp = true},
        .threads = {.motion_priority = 80, .stream_priority = 60, .motion_cpu = -1},
    };
}

bool gn_config_parse(struct gn_config *config, const char *file, const char *text, size_t length, char *error,
                     size_t error_size) {
    struct parser parser = {.config = config, .file = file, .error = error, .error_size = error_size};
    size_t at = 0;
    while (at < length) {
        const char *end = memchr(text + at, '\n', length - at);
        size_t const line_length = end == NULL ? length - at : (size_t)(end - (text + at));
        ++parser.line;
        if (!parse_line(&parser, text + at, line_length)) {
            return false;
        }
        at += line_length + 1u;
    }
    if (!config->link.tcp && config->link.functionfs[0] == '\0') {
        return complain(&parser, "neither link.functionfs nor link.tcp_port is there; no host could connect, set one",
                        "", 0, "");
    }
    return true;
}

bool gn_config_load(struct gn_config *config, const char *file, char *error, size_t error_size) {
    static char text[FILE_SIZE_MAX + 1u];
    FILE *stream = fopen(file, "re");
    if (stream == NULL) {
        (void)snprintf(error, error_size, "%s: %s; name the settings file with --config FILE", file, strerror(errno));
        return false;
    }
    errno = 0;
    size_t const length = fread(text, 1, sizeof text, stream);
    int const failure = ferror(stream) != 0 ? errno : 0;
    (void)fclose(stream);
    if (failure != 0 || length > FILE_SIZE_MAX) {
        (void)snprintf(error, error_size, "%s: %s", file,
                       failure != 0 ? strerror(failure) : "longer than 65536 bytes; this is no settings file");
        return false;
    }
    return gn_config_parse(config, file, text, length, error, error_size);
}
