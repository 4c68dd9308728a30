/* config_values.h: one value of the settings file, read into its place. */
#ifndef GONIO_CONFIG_VALUES_H
#define GONIO_CONFIG_VALUES_H

#include <stdbool.h>
#include <stddef.h>

struct gn_config_key;

/* false: the value cannot be taken; `rule` of the key says what can. Nothing was changed. */
typedef bool gn_config_reader(const struct gn_config_key *key, const char *value, void *place);

struct gn_config_key {
    const char *name;
    gn_config_reader *read;
    size_t offset; /* in struct gn_config */
    size_t size;   /* of the place, where it holds text */
    double min;
    double max;
    const char *empty; /* the word for "nothing here"; NULL: there must be something */
    const char *rule;  /* what may stand there, for the error line */
};

gn_config_reader gn_config_read_word;  /* letters, digits and ._- */
gn_config_reader gn_config_read_path;  /* absolute */
gn_config_reader gn_config_read_int;   /* int, from min to max */
gn_config_reader gn_config_read_count; /* uint32_t, from min to max */
gn_config_reader gn_config_read_float; /* float, from min to max */
gn_config_reader gn_config_read_cpu;   /* int, or `empty` for -1 */
gn_config_reader gn_config_read_port;  /* struct gn_link_settings: a number, any, none */
gn_config_reader gn_config_read_usb;   /* struct gn_digitiser_settings: VENDOR:PRODUCT in hexadecimal digits */
gn_config_reader gn_config_read_line;  /* struct gn_gpio_line: CHIP:OFFSET [active-low] */

#endif
