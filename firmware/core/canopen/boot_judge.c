/* boot_judge.c: judges the values that boot reads back. */
#include "boot_judge.h"

#include <stdio.h>

#define CIA402_PROFILE 0x0192u

static bool fail(struct gn_trouble *trouble, gonio_FaultCode code, const struct gn_boot_step *step,
                 const char *remedy) {
    trouble->code = code;
    trouble->index = step->index;
    trouble->subindex = step->subindex;
    trouble->remedy = remedy;
    return false;
}

static uint32_t size_mask(uint32_t size) {
    return size >= 4u ? UINT32_MAX : (1u << (8u * size)) - 1u;
}

/* The drive's own 0x60C2 must be the SYNC period, in whatever units it counts. */
static bool same_period(uint32_t units, int32_t exponent, uint32_t period_us) {
    uint64_t value = units;
    for (; exponent > -6 && value <= UINT32_MAX; exponent--) {
        value *= 10u;
    }
    return exponent == -6 && value == period_us;
}

static bool mismatch(const struct gn_boot_step *step, uint32_t wanted, uint32_t found, struct gn_trouble *trouble) {
    char name[16];
    gn_object_name(step->index, step->subindex, name, sizeof name);
    if (step->action == GN_BOOT_CHECK) {
        (void)snprintf(trouble->cause, sizeof trouble->cause, "%s (%s) is %lu, the axis configuration says %lu", name,
                       step->words, (unsigned long)found, (unsigned long)wanted);
        return fail(trouble, gonio_FaultCode_FAULT_WRONG_DEVICE, step, "check node id and counts_per_turn");
    }
    (void)snprintf(trouble->cause, sizeof trouble->cause, "%s (%s) is to be 0x%lX and reads back 0x%lX", name,
                   step->words, (unsigned long)wanted, (unsigned long)found);
    return fail(trouble, gonio_FaultCode_FAULT_READ_BACK, step,
                "the drive limits or ignores it: check the axis's limits");
}

static void take_identity(gonio_NodeInfo *info, uint8_t subindex, uint32_t value) {
    uint32_t *const fields[] = {&info->vendor, &info->product, &info->revision, &info->serial};
    *fields[subindex - 1u] = value;
}

bool gn_boot_judge(struct gn_axis *axis, const struct gn_bus *bus, const struct gn_boot_step *step,
                   struct gn_trouble *trouble) {
    struct gn_boot *boot = &axis->boot;
    uint32_t const found = gn_sdo_value(&axis->sdo) & size_mask(step->size);
    if (step->action == GN_BOOT_DEVICE_TYPE) {
        axis->info.device_type = found;
        if ((found & 0xFFFFu) != CIA402_PROFILE) {
            (void)snprintf(trouble->cause, sizeof trouble->cause,
                           "0x1000 (device type) is 0x%08lX, not a CiA 402 drive", (unsigned long)found);
            return fail(trouble, gonio_FaultCode_FAULT_WRONG_DEVICE, step, "check the node ids");
        }
        return true;
    }
    if (step->action == GN_BOOT_IDENTITY) {
        take_identity(&axis->info, step->subindex, found);
        return true;
    }
    if (step->fallback == GN_PERIOD && boot->period_read_only) {
        if (step->subindex == 1u) {
            boot->period_units = found;
            return true;
        }
        if (same_period(boot->period_units, (int8_t)found, bus->cycle->sync_period_us)) {
            return true;
        }
        (void)snprintf(trouble->cause, sizeof trouble->cause,
                       "0x60C2 (interpolation period) is read only, %lu * 10^%d s, and the SYNC period is %lu us",
                       (unsigned long)boot->period_units, (int8_t)found, (unsigned long)bus->cycle->sync_period_us);
        return fail(trouble, gonio_FaultCode_FAULT_READ_BACK, step, "set sync_period_us to the drive's period");
    }
    uint32_t const wanted = step->value(&axis->config, bus->cycle) & size_mask(step->size);
    if (((wanted ^ found) & ~step->ignored_bits) != 0u) {
        return mismatch(step, wanted, found, trouble);
    }
    return true;
}
