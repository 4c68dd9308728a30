/* blocks.h: gathers samples and poses into the payloads of SAMPLES and POSES frames. */
#ifndef GONIO_BLOCKS_H
#define GONIO_BLOCKS_H

#include <stdbool.h>
#include <stdint.h>

#include "digitiser_packets.h"
#include "gonio_records.h"
#include "sample_clock.h"

#define GN_BLOCK_SAMPLES_MAX 1000u
#define GN_BLOCK_POSES_MAX 50u
#define GN_BLOCK_AGE_NS INT64_C(100000000) /* no record waits longer for its block */

struct gn_sample_blocks {
    uint32_t limit; /* samples per block: about 100 ms */
    uint32_t next_block;
    uint32_t count;
    bool gap_before;
    uint64_t first_sample;
    int64_t arrival_ns;        /* of the first sample's packet */
    uint64_t strobes_rejected; /* up to the last block */
    uint8_t payload[GN_SAMPLE_BLOCK_SIZE + GN_BLOCK_SAMPLES_MAX * GN_SAMPLE_SIZE];
};

struct gn_pose_blocks {
    uint32_t next_block;
    uint32_t count;
    int64_t arrival_ns;
    uint8_t payload[GN_POSE_BLOCK_SIZE + GN_BLOCK_POSES_MAX * GN_POSE_SIZE];
};

/* Empty, numbered from 0, cut to about 100 ms of samples. */
void gn_sample_blocks_start(struct gn_sample_blocks *blocks, int64_t sample_period_ns);
/* true: the run does not continue the block in hand, which must be sealed first. */
bool gn_sample_blocks_breaks(const struct gn_sample_blocks *blocks, const struct gn_sample_run *run);
/* Takes from the front of the run what the block has room for. */
void gn_sample_blocks_take(struct gn_sample_blocks *blocks, struct gn_sample_run *run, int64_t now_ns);
bool gn_sample_blocks_full(const struct gn_sample_blocks *blocks);
/* Writes the header, gives the payload's length and begins the next block. `fit` is NULL while the clock is not
 * settled. */
uint32_t gn_sample_blocks_seal(struct gn_sample_blocks *blocks, const struct gn_clock_fit *fit,
                               const struct gn_digitiser_packets *packets, const struct gn_sample_clock *clock);

void gn_pose_blocks_start(struct gn_pose_blocks *blocks);
/* true: the block is full and must be sealed. */
bool gn_pose_blocks_take(struct gn_pose_blocks *blocks, const struct gn_pose *pose, int64_t now_ns);
/* `sync_stamp_sigma_us`: standard uncertainty of the poses' times. */
uint32_t gn_pose_blocks_seal(struct gn_pose_blocks *blocks, uint32_t axis_count, float sync_stamp_sigma_us);

#endif
