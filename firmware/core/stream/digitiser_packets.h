/* digitiser_packets.h: parses the digitiser's packets, unwraps their numbers and counts what is missing. */
#ifndef GONIO_DIGITISER_PACKETS_H
#define GONIO_DIGITISER_PACKETS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "gonio_records.h"

#define GN_DIGITISER_MAGIC 0x4744u
#define GN_PACKET_SAMPLES_MAX 255u
#define GN_PACKET_SIZE_MAX (GN_DIGITISER_PACKET_SIZE + GN_PACKET_SAMPLES_MAX * GN_SAMPLE_SIZE)

struct gn_digitiser_packets {
    bool started; /* a packet has come since START */
    uint16_t next_packet;
    uint64_t next_sample;
    /* since the controller's start */
    uint64_t samples;
    uint64_t samples_lost;
    uint64_t packets_lost;
};

/* Samples of one packet, still in the buffer that it was read into. */
struct gn_sample_run {
    uint64_t first_sample; /* since START */
    uint32_t count;
    bool gap_before;
    const uint8_t *records;
};

/* START sets the digitiser's numbers to 0; the counts go on. */
void gn_digitiser_packets_start(struct gn_digitiser_packets *packets);
/* false: no packet of this protocol, or one that repeats numbers; it counts as lost and gives no samples. */
bool gn_digitiser_packets_parse(struct gn_digitiser_packets *packets, const uint8_t *bytes, size_t length,
                                struct gn_sample_run *run);

#endif
