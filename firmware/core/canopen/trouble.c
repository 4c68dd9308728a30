/* trouble.c: names objects and puts failed SDO transfers into words. */
#include "trouble.h"

#include <stdio.h>

void gn_object_name(uint16_t index, uint8_t subindex, char *text, uint32_t size) {
    if (subindex == 0u) {
        (void)snprintf(text, size, "0x%04X", index);
    } else {
        (void)snprintf(text, size, "0x%04X:%02X", index, subindex);
    }
}

void gn_trouble_from_sdo(struct gn_trouble *trouble, const struct gn_sdo *sdo, const char *what) {
    char name[16];
    gn_object_name(sdo->index, sdo->subindex, name, sizeof name);
    trouble->index = sdo->index;
    trouble->subindex = sdo->subindex;
    if (sdo->state == GN_SDO_TIMED_OUT) {
        trouble->code = gonio_FaultCode_FAULT_SDO_TIMEOUT;
        trouble->remedy = "check its cable, or raise sdo_timeout_ms if the drive is slow";
        (void)snprintf(trouble->cause, sizeof trouble->cause, "no answer to %s (%s) within %lld ms", name, what,
                       (long long)(sdo->timeout_ns / 1000000));
        return;
    }
    trouble->code = gonio_FaultCode_FAULT_SDO_ABORT;
    trouble->remedy = "set the axis up for this drive, or change the drive";
    (void)snprintf(trouble->cause, sizeof trouble->cause, "%s of %s (%s) aborted: %s (0x%08lX)",
                   sdo->upload ? "reading" : "writing", name, what, gn_sdo_abort_words(sdo->abort_code),
                   (unsigned long)sdo->abort_code);
}
