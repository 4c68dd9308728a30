/* sdo.h: SDO client of one node (CiA 301): expedited and segmented upload, expedited download; never blocks. */
#ifndef GONIO_SDO_H
#define GONIO_SDO_H

#include <stdbool.h>
#include <stdint.h>

#include "can.h"

#define GN_SDO_CAPACITY 64u /* longest object taken, bytes: device names and versions */

enum gn_sdo_state {
    GN_SDO_IDLE = 0,
    GN_SDO_BUSY = 1,
    GN_SDO_DONE = 2,
    GN_SDO_ABORTED = 3,   /* abort_code says why, by either side */
    GN_SDO_TIMED_OUT = 4, /* no answer in time */
};

/* Abort codes of CiA 301 that the client sends, or that choose a fallback. */
enum gn_sdo_abort {
    GN_ABORT_TOGGLE = 0x05030000,
    GN_ABORT_TIMEOUT = 0x05040000,
    GN_ABORT_COMMAND = 0x05040001,
    GN_ABORT_MEMORY = 0x05040005,
    GN_ABORT_READ_ONLY = 0x06010002,
    GN_ABORT_NO_OBJECT = 0x06020000,
    GN_ABORT_LENGTH = 0x06070010,
    GN_ABORT_NO_SUBINDEX = 0x06090011,
    GN_ABORT_DEVICE_STATE = 0x08000022,
};

struct gn_sdo {
    uint32_t node;
    int64_t timeout_ns; /* per answer */
    enum gn_sdo_state state;
    bool segments; /* in a segmented upload */
    bool upload;
    uint8_t toggle; /* 0x00 or 0x10 */
    uint16_t index;
    uint8_t subindex;
    uint8_t data[GN_SDO_CAPACITY];
    uint32_t size;          /* bytes received */
    uint32_t expected_size; /* announced by the server; 0: not announced */
    uint32_t abort_code;
    int64_t deadline_ns;
};

void gn_sdo_init(struct gn_sdo *sdo, uint32_t node, int64_t timeout_ns);
/* false: a transfer is under way. */
bool gn_sdo_read(struct gn_sdo *sdo, const struct gn_can_port *can, uint16_t index, uint8_t subindex, int64_t now_ns);
/* Write 1, 2 or 4 bytes. */
bool gn_sdo_write(struct gn_sdo *sdo, const struct gn_can_port *can, uint16_t index, uint8_t subindex, uint32_t value,
                  uint32_t size, int64_t now_ns);
/* A frame from the server (COB 0x580 + node). Frames of a transfer given up before are ignored. */
void gn_sdo_on_frame(struct gn_sdo *sdo, const struct gn_can_port *can, const struct gn_can_frame *frame,
                     int64_t now_ns);
/* Give up when the answer is overdue. */
void gn_sdo_process(struct gn_sdo *sdo, const struct gn_can_port *can, int64_t now_ns);
/* Forget the transfer, finished or not. */
void gn_sdo_reset(struct gn_sdo *sdo);
/* The value read, little-endian, of its first four bytes at most. */
uint32_t gn_sdo_value(const struct gn_sdo *sdo);

/* The standard's words for an abort code. */
const char *gn_sdo_abort_words(uint32_t code);

#endif
