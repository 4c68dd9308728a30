/* blocks.c: records are copied as they came; only the block's header is made here. */
#include "blocks.h"

#include <string.h>

void gn_sample_blocks_start(struct gn_sample_blocks *blocks, int64_t sample_period_ns) {
    int64_t const fitting = GN_BLOCK_AGE_NS / sample_period_ns;
    blocks->limit = fitting < 1                               ? 1u
                    : fitting > (int64_t)GN_BLOCK_SAMPLES_MAX ? GN_BLOCK_SAMPLES_MAX
                                                              : (uint32_t)fitting;
    blocks->next_block = 0;
    blocks->count = 0;
    blocks->gap_before = false;
}

bool gn_sample_blocks_breaks(const struct gn_sample_blocks *blocks, const struct gn_sample_run *run) {
    return run->gap_before && blocks->count > 0u;
}

void gn_sample_blocks_take(struct gn_sample_blocks *blocks, struct gn_sample_run *run, int64_t now_ns) {
    if (blocks->count == 0u) {
        blocks->first_sample = run->first_sample;
        blocks->arrival_ns = now_ns;
        blocks->gap_before = run->gap_before;
    }
    uint32_t const room = blocks->limit - blocks->count;
    uint32_t const part = run->count < room ? run->count : room;
    memcpy(blocks->payload + GN_SAMPLE_BLOCK_SIZE + (size_t)blocks->count * GN_SAMPLE_SIZE, run->records,
           (size_t)part * GN_SAMPLE_SIZE);
    blocks->count += part;
    run->first_sample += part;
    run->records += (size_t)part * GN_SAMPLE_SIZE;
    run->count -= part;
    run->gap_before = false;
}

bool gn_sample_blocks_full(const struct gn_sample_blocks *blocks) {
    return blocks->count == blocks->limit;
}

uint32_t gn_sample_blocks_seal(struct gn_sample_blocks *blocks, const struct gn_clock_fit *fit,
                               const struct gn_digitiser_packets *packets, const struct gn_sample_clock *clock) {
    struct gn_sample_block header = {
        .first_sample = blocks->first_sample,
        .first_time_ns = blocks->arrival_ns,
        .period_ns = (double)clock->settings.sample_period_ns,
        .block = blocks->next_block++,
        .count = blocks->count,
        .samples_lost = (uint32_t)packets->samples_lost,
        .strobes_lost = (uint32_t)(clock->strobes_lost + clock->strobes_rejected),
        .flags = blocks->gap_before ? GN_SAMPLE_BLOCK_GAP_BEFORE : 0u,
    };
    if (fit != NULL) {
        header.first_time_ns = gn_clock_time_ns(fit, (int64_t)blocks->first_sample);
        header.period_ns = gn_clock_period_ns(fit);
        header.residual_ns = (float)fit->residual_ns;
        header.window = fit->window;
    } else {
        header.flags |= GN_SAMPLE_BLOCK_CLOCK_UNSETTLED;
    }
    if (clock->strobes_rejected != blocks->strobes_rejected) {
        header.flags |= GN_SAMPLE_BLOCK_STROBE_REJECTED;
        blocks->strobes_rejected = clock->strobes_rejected;
    }
    memcpy(blocks->payload, &header, sizeof header);
    blocks->count = 0;
    return GN_SAMPLE_BLOCK_SIZE + header.count * GN_SAMPLE_SIZE;
}

void gn_pose_blocks_start(struct gn_pose_blocks *blocks) {
    blocks->next_block = 0;
    blocks->count = 0;
}

bool gn_pose_blocks_take(struct gn_pose_blocks *blocks, const struct gn_pose *pose, int64_t now_ns) {
    if (blocks->count == 0u) {
        blocks->arrival_ns = now_ns;
    }
    memcpy(blocks->payload + GN_POSE_BLOCK_SIZE + (size_t)blocks->count * GN_POSE_SIZE, pose, GN_POSE_SIZE);
    return ++blocks->count == GN_BLOCK_POSES_MAX;
}

uint32_t gn_pose_blocks_seal(struct gn_pose_blocks *blocks, uint32_t axis_count, float sync_stamp_sigma_us) {
    struct gn_pose_block const header = {.block = blocks->next_block++,
                                         .count = blocks->count,
                                         .axis_count = axis_count,
                                         .sync_stamp_sigma_us = sync_stamp_sigma_us};
    memcpy(blocks->payload, &header, sizeof header);
    blocks->count = 0;
    return GN_POSE_BLOCK_SIZE + header.count * GN_POSE_SIZE;
}
