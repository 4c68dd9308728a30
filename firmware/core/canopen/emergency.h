/* emergency.h: EMCY error codes (CiA 301, CiA 402) in words, with the usual remedy. */
#ifndef GONIO_EMERGENCY_H
#define GONIO_EMERGENCY_H

#include <stdint.h>

#include "gonio.pb.h"

#define GN_EMCY_COB 0x080u /* + node */

struct gn_emergency_words {
    uint16_t code, mask;
    gonio_FaultCode fault;
    const char *words;
    const char *remedy;
};

/* Never NULL: the last entry fits every code. */
const struct gn_emergency_words *gn_emergency_of(uint16_t code);

#endif
