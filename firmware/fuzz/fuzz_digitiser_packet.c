/* fuzz_digitiser_packet.c: packets of any bytes, through the parser and into blocks; the numbers must stay consistent.
 */
#include <stdlib.h>
#include <string.h>

#include "blocks.h"
#include "digitiser_packets.h"
#include "sample_clock.h"

static void check_block(struct gn_sample_blocks *blocks, const struct gn_digitiser_packets *packets,
                        const struct gn_sample_clock *clock) {
    uint32_t const count = blocks->count;
    uint32_t const length = gn_sample_blocks_seal(blocks, NULL, packets, clock);
    if (length > sizeof blocks->payload || length != GN_SAMPLE_BLOCK_SIZE + count * GN_SAMPLE_SIZE) {
        abort();
    }
}

static void take(struct gn_sample_blocks *blocks, struct gn_sample_run *run, const struct gn_digitiser_packets *packets,
                 const struct gn_sample_clock *clock) {
    if (gn_sample_blocks_breaks(blocks, run)) {
        check_block(blocks, packets, clock);
    }
    while (run->count > 0u) {
        gn_sample_blocks_take(blocks, run, 0);
        if (gn_sample_blocks_full(blocks)) {
            check_block(blocks, packets, clock);
        }
    }
}

/* Input: a packet length (2 bytes), that many bytes, and so on; magic and count are put right when the top bit is set.
 */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct gn_sample_blocks blocks;
    struct gn_digitiser_packets packets = {.started = false};
    struct gn_sample_clock clock = {.running = false};
    gn_digitiser_packets_start(&packets);
    gn_sample_blocks_start(&blocks, 1000000);
    uint64_t next_sample = 0;
    while (size >= 2u) {
        uint8_t packet[GN_PACKET_SIZE_MAX];
        bool const put_right = (data[1] & 0x80u) != 0u;
        size_t length = (size_t)data[0] | (size_t)(data[1] & 0x0Fu) << 8u;
        data += 2;
        size -= 2u;
        length = length < size ? length : size;
        length = length < sizeof packet ? length : sizeof packet;
        memcpy(packet, data, length);
        data += length;
        size -= length;
        if (put_right && length >= GN_DIGITISER_PACKET_SIZE) {
            struct gn_digitiser_packet header;
            memcpy(&header, packet, sizeof header);
            header.magic = GN_DIGITISER_MAGIC;
            header.count = (uint16_t)((length - sizeof header) / GN_SAMPLE_SIZE);
            memcpy(packet, &header, sizeof header);
            length = sizeof header + (size_t)header.count * GN_SAMPLE_SIZE;
        }
        struct gn_sample_run run;
        if (gn_digitiser_packets_parse(&packets, packet, length, &run)) {
            if (run.first_sample < next_sample || run.count > GN_PACKET_SAMPLES_MAX) {
                abort();
            }
            next_sample = run.first_sample + run.count;
            take(&blocks, &run, &packets, &clock);
        }
    }
    if (packets.samples + packets.samples_lost != next_sample) {
        abort();
    }
    return 0;
}
