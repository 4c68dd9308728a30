/* acquisition.c: starts and stops the digitiser and moves its samples into blocks on the driver's session. */
#include "acquisition.h"

#include <stddef.h>

static void take_strobes(struct gn_acquisition *acquisition) {
    struct gn_edge edge;
    while (gn_ring_pop(acquisition->strobes, &edge)) {
        gn_sample_clock_edge(&acquisition->clock, &edge);
    }
}

static void send_block(struct gn_acquisition *acquisition, int64_t now_ns) {
    struct gn_clock_fit fit;
    bool const settled = gn_sample_clock_fit(&acquisition->clock, now_ns, &fit);
    uint32_t const length =
        gn_sample_blocks_seal(&acquisition->blocks, settled ? &fit : NULL, &acquisition->packets, &acquisition->clock);
    gn_session_block(acquisition->session, GN_FRAME_SAMPLES, acquisition->blocks.payload, length);
}

static void take_run(struct gn_acquisition *acquisition, struct gn_sample_run *run, int64_t now_ns) {
    if (gn_sample_blocks_breaks(&acquisition->blocks, run)) {
        send_block(acquisition, now_ns);
    }
    while (run->count > 0u) {
        gn_sample_blocks_take(&acquisition->blocks, run, now_ns);
        if (gn_sample_blocks_full(&acquisition->blocks)) {
            send_block(acquisition, now_ns);
        }
    }
}

static bool take_packets(struct gn_acquisition *acquisition, int64_t now_ns) {
    uint8_t packet[GN_PACKET_SIZE_MAX];
    const struct gn_digitiser_port *digitiser = acquisition->digitiser;
    int length = digitiser->read(digitiser->context, packet, sizeof packet);
    while (length > 0) {
        struct gn_sample_run run;
        if (gn_digitiser_packets_parse(&acquisition->packets, packet, (size_t)length, &run)) {
            take_run(acquisition, &run, now_ns);
        }
        length = digitiser->read(digitiser->context, packet, sizeof packet);
    }
    return length == 0;
}

bool gn_acquisition_start(struct gn_acquisition *acquisition, const gonio_Configure *configuration) {
    struct gn_clock_settings const settings = {
        .sample_period_ns = (int64_t)configuration->sample_period_us * 1000,
        .samples_per_strobe = configuration->samples_per_strobe,
        .settle_ns = (int64_t)configuration->clock_settle_ms * 1000000,
        .tolerance_percent = configuration->edge_tolerance_percent,
    };
    take_strobes(acquisition); /* of before: only their numbers matter */
    gn_digitiser_packets_start(&acquisition->packets);
    gn_sample_blocks_start(&acquisition->blocks, settings.sample_period_ns);
    gn_sample_clock_start(&acquisition->clock, &settings);
    acquisition->on = acquisition->digitiser->start(acquisition->digitiser->context, configuration->sample_period_us,
                                                    configuration->samples_per_strobe) == 0;
    if (!acquisition->on) {
        gn_sample_clock_stop(&acquisition->clock);
    }
    return acquisition->on;
}

static void end(struct gn_acquisition *acquisition, int64_t now_ns) {
    if (acquisition->blocks.count > 0u) {
        send_block(acquisition, now_ns);
    }
    gn_sample_clock_stop(&acquisition->clock);
    acquisition->on = false;
}

void gn_acquisition_stop(struct gn_acquisition *acquisition, int64_t now_ns) {
    if (!acquisition->on) {
        return;
    }
    acquisition->digitiser->stop(acquisition->digitiser->context);
    take_strobes(acquisition);
    (void)take_packets(acquisition, now_ns);
    end(acquisition, now_ns);
}

const char *gn_acquisition_process(struct gn_acquisition *acquisition, int64_t now_ns) {
    take_strobes(acquisition);
    if (!acquisition->on) {
        return NULL;
    }
    if (!take_packets(acquisition, now_ns)) {
        end(acquisition, now_ns);
        return "the digitiser is gone; check its cable and power, then acquire again";
    }
    if (gn_sample_clock_silent(&acquisition->clock, now_ns)) {
        gn_acquisition_stop(acquisition, now_ns);
        return "the digitiser's strobe stays away, so its samples have no time; check the strobe line, then acquire "
               "again";
    }
    /* A block that waits this long has missed packets: it goes as it is. */
    if (acquisition->blocks.count > 0u && now_ns - acquisition->blocks.arrival_ns >= 2 * GN_BLOCK_AGE_NS) {
        send_block(acquisition, now_ns);
    }
    return NULL;
}
