/* config_values.c: readers for each kind of value in the settings file; none changes anything unless all of it is good.
 */
#include "config_values.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"

#define OFFSET_MAX 1023L /* lines of a chip; the largest known has 512 */

static bool is_empty(const struct gn_config_key *key, const char *value) {
    return key->empty != NULL && strcmp(value, key->empty) == 0;
}

static bool is_word(const char *text) {
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
    return text[0] != '\0' && text[strspn(text, allowed)] == '\0';
}

/* Decimal digits alone: no sign, no space, no octal surprise. */
static bool read_digits(const char *text, long min, long max, long *number) {
    size_t const digits = strspn(text, "0123456789");
    if (digits == 0u || digits > 9u || text[digits] != '\0') {
        return false;
    }
    *number = strtol(text, NULL, 10);
    return *number >= min && *number <= max;
}

static bool store_text(const struct gn_config_key *key, const char *value, void *place) {
    size_t const length = strlen(value);
    if (length >= key->size) {
        return false;
    }
    memset(place, 0, key->size);
    memcpy(place, value, length);
    return true;
}

bool gn_config_read_word(const struct gn_config_key *key, const char *value, void *place) {
    if (is_empty(key, value)) {
        return store_text(key, "", place);
    }
    return is_word(value) && store_text(key, value, place);
}

bool gn_config_read_path(const struct gn_config_key *key, const char *value, void *place) {
    if (is_empty(key, value)) {
        return store_text(key, "", place);
    }
    return value[0] == '/' && store_text(key, value, place);
}

bool gn_config_read_int(const struct gn_config_key *key, const char *value, void *place) {
    long number = 0;
    if (!read_digits(value, (long)key->min, (long)key->max, &number)) {
        return false;
    }
    *(int *)place = (int)number;
    return true;
}

bool gn_config_read_count(const struct gn_config_key *key, const char *value, void *place) {
    long number = 0;
    if (!read_digits(value, (long)key->min, (long)key->max, &number)) {
        return false;
    }
    *(uint32_t *)place = (uint32_t)number;
    return true;
}

bool gn_config_read_float(const struct gn_config_key *key, const char *value, void *place) {
    if (value[0] == '\0' || value[strspn(value, "0123456789.")] != '\0') {
        return false; /* strtod would also take hexadecimal digits, inf and nan */
    }
    char *end = NULL;
    double const number = strtod(value, &end);
    if (*end != '\0' || !isfinite(number) || number < key->min || number > key->max) {
        return false;
    }
    *(float *)place = (float)number;
    return true;
}

bool gn_config_read_cpu(const struct gn_config_key *key, const char *value, void *place) {
    if (is_empty(key, value)) {
        *(int *)place = -1;
        return true;
    }
    return gn_config_read_int(key, value, place);
}

bool gn_config_read_port(const struct gn_config_key *key, const char *value, void *place) {
    struct gn_link_settings *link = place;
    long number = 0;
    if (is_empty(key, value)) {
        link->tcp = false;
        return true;
    }
    if (strcmp(value, "any") != 0 && !read_digits(value, (long)key->min, (long)key->max, &number)) {
        return false;
    }
    link->tcp = true;
    link->tcp_port = (uint16_t)number;
    return true;
}

static bool read_hex4(const char *text, uint16_t *number) {
    if (strspn(text, "0123456789abcdefABCDEF") < 4u) {
        return false;
    }
    char const digits[5] = {text[0], text[1], text[2], text[3], '\0'};
    *number = (uint16_t)strtoul(digits, NULL, 16);
    return true;
}

bool gn_config_read_usb(const struct gn_config_key *key, const char *value, void *place) {
    (void)key;
    struct gn_digitiser_settings *digitiser = place;
    uint16_t vendor = 0;
    uint16_t product = 0;
    if (strlen(value) != 9u || value[4] != ':' || !read_hex4(value, &vendor) || !read_hex4(value + 5, &product)) {
        return false;
    }
    digitiser->vendor_id = vendor;
    digitiser->product_id = product;
    return true;
}

/* gpiochip0 is the device /dev/gpiochip0; another word is a label, which stays the same when chips are numbered anew.
 */
static bool read_chip(const char *text, size_t length, char *chip, size_t size) {
    char name[64];
    if (length == 0u || length >= sizeof name) {
        return false;
    }
    memcpy(name, text, length);
    name[length] = '\0';
    bool const device =
        strncmp(name, "gpiochip", 8) == 0 && name[8] != '\0' && name[8 + strspn(name + 8, "0123456789")] == '\0';
    if (name[0] != '/' && !is_word(name)) {
        return false;
    }
    int const written = snprintf(chip, size, "%s%s", device ? "/dev/" : "", name);
    return written > 0 && (size_t)written < size;
}

bool gn_config_read_line(const struct gn_config_key *key, const char *value, void *place) {
    struct gn_gpio_line line = {.used = true};
    if (is_empty(key, value)) {
        *(struct gn_gpio_line *)place = (struct gn_gpio_line){.used = false};
        return true;
    }
    const char *colon = strrchr(value, ':');
    if (colon == NULL || !read_chip(value, (size_t)(colon - value), line.chip, sizeof line.chip)) {
        return false;
    }
    char digits[16];
    size_t const count = strspn(colon + 1, "0123456789");
    const char *rest = colon + 1 + count;
    long offset = 0;
    if (count >= sizeof digits) {
        return false;
    }
    memcpy(digits, colon + 1, count);
    digits[count] = '\0';
    if (!read_digits(digits, 0, OFFSET_MAX, &offset)) {
        return false;
    }
    line.offset = (uint32_t)offset;
    if (*rest != '\0') {
        size_t const blanks = strspn(rest, " \t");
        line.active_low = blanks > 0u && strcmp(rest + blanks, "active-low") == 0;
        if (!line.active_low) {
            return false;
        }
    }
    *(struct gn_gpio_line *)place = line;
    return true;
}
