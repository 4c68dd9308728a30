/* trouble.h: what went wrong at one node, before it becomes a fault's sentence. */
#ifndef GONIO_TROUBLE_H
#define GONIO_TROUBLE_H

#include <stdint.h>

#include "gonio.pb.h"
#include "sdo.h"

struct gn_trouble {
    gonio_FaultCode code;
    uint16_t index; /* object, or 0 */
    uint8_t subindex;
    char cause[120];
    const char *remedy;
};

/* "0x6065", or "0x1400:05" for a subindex other than 0. */
void gn_object_name(uint16_t index, uint8_t subindex, char *text, uint32_t size);
/* A transfer that ended ABORTED or TIMED_OUT; `what` is the object in words. */
void gn_trouble_from_sdo(struct gn_trouble *trouble, const struct gn_sdo *sdo, const char *what);

#endif
