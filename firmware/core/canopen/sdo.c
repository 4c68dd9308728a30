/* sdo.c: SDO client of one node; one transfer at a time, driven by received frames and the time. */
#include "sdo.h"

#include <string.h>

#define COMMAND_MASK 0xE0u
#define CLIENT_DOWNLOAD 0x20u
#define CLIENT_UPLOAD 0x40u
#define CLIENT_UPLOAD_SEGMENT 0x60u
#define SERVER_UPLOAD_SEGMENT 0x00u
#define SERVER_UPLOAD 0x40u
#define SERVER_DOWNLOAD 0x60u
#define ABORT 0x80u
#define TOGGLE 0x10u
#define EXPEDITED 0x02u
#define SIZE_GIVEN 0x01u
#define LAST_SEGMENT 0x01u

static uint32_t little_endian(const uint8_t *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static void put_little_endian(uint8_t *bytes, uint32_t value) {
    for (uint32_t i = 0; i < 4u; i++) {
        bytes[i] = (uint8_t)(value >> (8u * i));
    }
}

/* A frame that does not fit into the transmit queue is lost like one on the bus: the answer's time-out reports it. */
static void send(const struct gn_sdo *sdo, const struct gn_can_port *can, uint8_t command, uint32_t value) {
    struct gn_can_frame frame = {.id = 0x600u + sdo->node, .length = 8};
    frame.data[0] = command;
    if (command != (CLIENT_UPLOAD_SEGMENT | sdo->toggle)) {
        frame.data[1] = (uint8_t)sdo->index;
        frame.data[2] = (uint8_t)(sdo->index >> 8);
        frame.data[3] = sdo->subindex;
        put_little_endian(frame.data + 4, value);
    }
    (void)can->send(can->context, &frame);
}

static void abort_transfer(struct gn_sdo *sdo, const struct gn_can_port *can, uint32_t code) {
    sdo->state = code == (uint32_t)GN_ABORT_TIMEOUT ? GN_SDO_TIMED_OUT : GN_SDO_ABORTED;
    sdo->abort_code = code;
    send(sdo, can, ABORT, code);
}

void gn_sdo_init(struct gn_sdo *sdo, uint32_t node, int64_t timeout_ns) {
    *sdo = (struct gn_sdo){.node = node, .timeout_ns = timeout_ns};
}

void gn_sdo_reset(struct gn_sdo *sdo) {
    gn_sdo_init(sdo, sdo->node, sdo->timeout_ns);
}

static bool begin(struct gn_sdo *sdo, uint16_t index, uint8_t subindex, bool upload, int64_t now_ns) {
    if (sdo->state == GN_SDO_BUSY) {
        return false;
    }
    gn_sdo_reset(sdo);
    sdo->state = GN_SDO_BUSY;
    sdo->index = index;
    sdo->subindex = subindex;
    sdo->upload = upload;
    sdo->deadline_ns = now_ns + sdo->timeout_ns;
    return true;
}

bool gn_sdo_read(struct gn_sdo *sdo, const struct gn_can_port *can, uint16_t index, uint8_t subindex, int64_t now_ns) {
    if (!begin(sdo, index, subindex, true, now_ns)) {
        return false;
    }
    send(sdo, can, CLIENT_UPLOAD, 0);
    return true;
}

bool gn_sdo_write(struct gn_sdo *sdo, const struct gn_can_port *can, uint16_t index, uint8_t subindex, uint32_t value,
                  uint32_t size, int64_t now_ns) {
    if (!begin(sdo, index, subindex, false, now_ns)) {
        return false;
    }
    uint32_t const mask = size >= 4u ? UINT32_MAX : (1u << (8u * size)) - 1u;
    send(sdo, can, (uint8_t)(CLIENT_DOWNLOAD | (4u - size) << 2 | EXPEDITED | SIZE_GIVEN), value & mask);
    return true;
}

static void on_upload(struct gn_sdo *sdo, const struct gn_can_port *can, const uint8_t *data, int64_t now_ns) {
    uint8_t const command = data[0];
    if (command & EXPEDITED) {
        sdo->size = command & SIZE_GIVEN ? 4u - (command >> 2 & 3u) : 4u;
        memcpy(sdo->data, data + 4, sdo->size);
        sdo->state = GN_SDO_DONE;
        return;
    }
    sdo->expected_size = command & SIZE_GIVEN ? little_endian(data + 4) : 0u;
    if (sdo->expected_size > GN_SDO_CAPACITY) {
        abort_transfer(sdo, can, GN_ABORT_MEMORY);
        return;
    }
    sdo->segments = true;
    sdo->deadline_ns = now_ns + sdo->timeout_ns;
    send(sdo, can, CLIENT_UPLOAD_SEGMENT, 0);
}

static void on_segment(struct gn_sdo *sdo, const struct gn_can_port *can, const uint8_t *data, int64_t now_ns) {
    if ((data[0] & TOGGLE) != sdo->toggle) {
        abort_transfer(sdo, can, GN_ABORT_TOGGLE);
        return;
    }
    uint32_t const count = 7u - (data[0] >> 1 & 7u);
    if (sdo->size + count > GN_SDO_CAPACITY) {
        abort_transfer(sdo, can, GN_ABORT_MEMORY);
        return;
    }
    memcpy(sdo->data + sdo->size, data + 1, count);
    sdo->size += count;
    if (data[0] & LAST_SEGMENT) {
        if (sdo->expected_size != 0u && sdo->size != sdo->expected_size) {
            abort_transfer(sdo, can, GN_ABORT_LENGTH);
            return;
        }
        sdo->state = GN_SDO_DONE;
        return;
    }
    sdo->toggle ^= TOGGLE;
    sdo->deadline_ns = now_ns + sdo->timeout_ns;
    send(sdo, can, (uint8_t)(CLIENT_UPLOAD_SEGMENT | sdo->toggle), 0);
}

void gn_sdo_on_frame(struct gn_sdo *sdo, const struct gn_can_port *can, const struct gn_can_frame *frame,
                     int64_t now_ns) {
    if (sdo->state != GN_SDO_BUSY || frame->length != 8u) {
        return;
    }
    const uint8_t *data = frame->data;
    uint8_t const command = data[0] & COMMAND_MASK;
    if (sdo->segments && command == SERVER_UPLOAD_SEGMENT) {
        on_segment(sdo, can, data, now_ns);
        return;
    }
    if (data[1] != (uint8_t)sdo->index || data[2] != (uint8_t)(sdo->index >> 8) || data[3] != sdo->subindex) {
        return;
    }
    if (command == ABORT) {
        sdo->state = GN_SDO_ABORTED;
        sdo->abort_code = little_endian(data + 4);
    } else if (!sdo->segments && sdo->upload && command == SERVER_UPLOAD) {
        on_upload(sdo, can, data, now_ns);
    } else if (!sdo->upload && command == SERVER_DOWNLOAD) {
        sdo->state = GN_SDO_DONE;
    } else {
        abort_transfer(sdo, can, GN_ABORT_COMMAND);
    }
}

void gn_sdo_process(struct gn_sdo *sdo, const struct gn_can_port *can, int64_t now_ns) {
    if (sdo->state == GN_SDO_BUSY && now_ns >= sdo->deadline_ns) {
        abort_transfer(sdo, can, GN_ABORT_TIMEOUT);
    }
}

uint32_t gn_sdo_value(const struct gn_sdo *sdo) {
    uint32_t value = 0;
    for (uint32_t i = 0; i < sdo->size && i < 4u; i++) {
        value |= (uint32_t)sdo->data[i] << (8u * i);
    }
    return value;
}
