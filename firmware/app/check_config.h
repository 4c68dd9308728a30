/* check_config.h: `goniod --check-config`: each setting, and whether what it names is there. Opens nothing for use. */
#ifndef GONIO_CHECK_CONFIG_H
#define GONIO_CHECK_CONFIG_H

#include "config.h"

/* Prints one line per setting; 0: all devices are there, 1: some are not. */
int gn_check_config(const struct gn_config *config, const char *file);

#endif
