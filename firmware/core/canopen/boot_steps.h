/* boot_steps.h: the steps of a drive's boot, as a table. */
#ifndef GONIO_BOOT_STEPS_H
#define GONIO_BOOT_STEPS_H

#include <stdint.h>

#include "gonio.pb.h"

enum gn_boot_action {
    GN_BOOT_RESET, /* NMT reset communication */
    GN_BOOT_WAIT_BOOT_UP,
    GN_BOOT_DEVICE_TYPE, /* read into NodeInfo; must be a CiA 402 drive */
    GN_BOOT_IDENTITY,    /* read into NodeInfo */
    GN_BOOT_CHECK,       /* read and compare */
    GN_BOOT_UNITS,       /* read; the last of them is judged with those before it */
    GN_BOOT_WRITE,       /* write and read back */
    GN_BOOT_MONITOR,     /* from here on heartbeats are due */
    GN_BOOT_WAIT_FOR_OTHERS,
    GN_BOOT_START,            /* NMT start */
    GN_BOOT_WAIT_OPERATIONAL, /* heartbeat says so, and a statusword came */
};

/* What to do with a drive that does not have, or does not let write, an object. */
enum gn_boot_fallback {
    GN_REQUIRED,
    GN_NOTE_ABSENT,
    GN_SKIP_ABSENT,
    GN_SKIP_READ_ONLY,  /* a later step reads the value */
    GN_EQUAL_READ_ONLY, /* must hold the value already */
    GN_PERIOD,          /* 0x60C2: absent = note; read only = must be the SYNC period */
    GN_DEADLINE,        /* 0x1400:05: absent = slow, with a note */
    GN_FIXED_MAP,       /* read the map and use it */
    GN_BRAKE_ONLY,      /* axes with a brake; absent = note */
};

struct gn_boot_step {
    enum gn_boot_action action;
    uint16_t index;
    uint8_t subindex;
    uint8_t size; /* bytes */
    enum gn_boot_fallback fallback;
    uint32_t ignored_bits; /* of the value read back */
    uint32_t (*value)(const gonio_AxisConfig *axis, const gonio_Configure *cycle);
    const char *words;
};

extern const struct gn_boot_step gn_boot_steps[];
extern const uint32_t gn_boot_step_count;

#endif
