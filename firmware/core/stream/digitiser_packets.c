/* digitiser_packets.c: the 16-bit packet counter and the 32-bit sample number wrap; here they become 64-bit numbers. */
#include "digitiser_packets.h"

#include <string.h>

void gn_digitiser_packets_start(struct gn_digitiser_packets *packets) {
    packets->started = false;
    packets->next_packet = 0;
    packets->next_sample = 0;
}

static bool well_formed(const uint8_t *bytes, size_t length, struct gn_digitiser_packet *header) {
    if (length < sizeof *header) {
        return false;
    }
    memcpy(header, bytes, sizeof *header);
    return header->magic == GN_DIGITISER_MAGIC && header->count <= GN_PACKET_SAMPLES_MAX &&
           length == sizeof *header + (size_t)header->count * GN_SAMPLE_SIZE;
}

bool gn_digitiser_packets_parse(struct gn_digitiser_packets *packets, const uint8_t *bytes, size_t length,
                                struct gn_sample_run *run) {
    struct gn_digitiser_packet header;
    if (!well_formed(bytes, length, &header)) {
        return false; /* its number stays missing, so the next packet's jump counts it */
    }
    uint32_t const skipped = header.first_sample - (uint32_t)packets->next_sample;
    if (skipped > UINT32_MAX / 2u) {
        return false; /* behind what has come already */
    }
    /* The counter's place at START is taken from the first packet if that has sample 0, so that only losses count. */
    uint16_t const expected = packets->started || skipped > 0u ? packets->next_packet : header.packet;
    packets->packets_lost += (uint16_t)(header.packet - expected);
    packets->samples_lost += skipped;
    packets->samples += header.count;
    *run = (struct gn_sample_run){.first_sample = packets->next_sample + skipped,
                                  .count = header.count,
                                  .gap_before = skipped > 0u || header.packet != expected || (header.flags & 1u) != 0u,
                                  .records = bytes + sizeof header};
    packets->started = true;
    packets->next_packet = (uint16_t)(header.packet + 1u);
    packets->next_sample += (uint64_t)skipped + header.count;
    return true;
}
