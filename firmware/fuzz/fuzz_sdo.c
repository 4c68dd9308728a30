/* fuzz_sdo.c: any sequence of requests, server frames and times against the SDO client. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "sdo.h"

static int send(void *context, const struct gn_can_frame *frame) {
    uint32_t *sent = context;
    if (frame->id != 0x601u || frame->length != 8u) {
        __builtin_trap();
    }
    ++*sent;
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Each step is ten bytes: what to do, a time step, and eight bytes of data. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint32_t sent = 0;
    struct gn_can_port const can = {.context = &sent, .send = send};
    struct gn_sdo sdo;
    int64_t now_ns = 0;
    gn_sdo_init(&sdo, 1, 1000000);
    for (; size >= 10u; data += 10, size -= 10u) {
        struct gn_can_frame frame = {.id = 0x581, .length = data[0] >> 4};
        uint32_t const before = sent;
        memcpy(frame.data, data + 2, 8);
        now_ns += (int64_t)data[1] * 10000;
        switch (data[0] & 0x0Fu) {
        case 0:
            (void)gn_sdo_read(&sdo, &can, (uint16_t)(data[2] | data[3] << 8), data[4], now_ns);
            break;
        case 1:
            (void)gn_sdo_write(&sdo, &can, (uint16_t)(data[2] | data[3] << 8), data[4], data[5], 1u << data[6] % 3u,
                               now_ns);
            break;
        case 2:
            gn_sdo_process(&sdo, &can, now_ns);
            break;
        case 3: /* the right object, so that the rest of the frame matters */
            frame.data[1] = (uint8_t)sdo.index;
            frame.data[2] = (uint8_t)(sdo.index >> 8);
            frame.data[3] = sdo.subindex;
            frame.length = 8;
            gn_sdo_on_frame(&sdo, &can, &frame, now_ns);
            break;
        case 4:
            frame.length = 8;
            gn_sdo_on_frame(&sdo, &can, &frame, now_ns);
            break;
        default:
            gn_sdo_on_frame(&sdo, &can, &frame, now_ns);
            break;
        }
        if (sdo.size > GN_SDO_CAPACITY || sent > before + 1u || gn_sdo_abort_words(sdo.abort_code) == NULL) {
            __builtin_trap();
        }
        (void)gn_sdo_value(&sdo);
    }
    return 0;
}
