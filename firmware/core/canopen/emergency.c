/* emergency.c: what an EMCY error code means and what usually helps; the most special entry first. */
#include "emergency.h"

#define EMERGENCY gonio_FaultCode_FAULT_EMERGENCY

static const struct gn_emergency_words table[] = {
    {0x8611, 0xFFFF, gonio_FaultCode_FAULT_FOLLOWING_ERROR, "following error",
     "free the axis, or lower speed and acceleration"},
    {0x3210, 0xFFFF, EMERGENCY, "DC link over-voltage", "lower the deceleration or check the brake resistor"},
    {0x3220, 0xFFFF, EMERGENCY, "DC link under-voltage", "check the motor supply"},
    {0x4210, 0xFFFF, EMERGENCY, "drive too hot", "let it cool and check its load"},
    {0x7305, 0xFFFF, EMERGENCY, "encoder 1 error", "check the encoder's cable"},
    {0x7320, 0xFFFF, EMERGENCY, "position sensor error", "check the encoder's cable"},
    {0x8130, 0xFFFF, EMERGENCY, "the firmware's heartbeat was missed", "check the cable and the bus load"},
    {0x8240, 0xFFFF, EMERGENCY, "unexpected SYNC length", "check 0x1019"},
    {0x8250, 0xFFFF, EMERGENCY, "RPDO time-out", "check the cable and the bus load"},
    {0x8110, 0xFFFF, EMERGENCY, "CAN overrun", "check the bus load"},
    {0x8140, 0xFFFF, EMERGENCY, "recovered from bus off", "check cable and terminators"},
    {0x2000, 0xF000, EMERGENCY, "current error", "check the motor's cable and load"},
    {0x3000, 0xF000, EMERGENCY, "voltage error", "check the supplies"},
    {0x4000, 0xF000, EMERGENCY, "temperature error", "let it cool and check its load"},
    {0x5000, 0xF000, EMERGENCY, "drive hardware error", "power it off and on; replace it if this comes back"},
    {0x6000, 0xF000, EMERGENCY, "drive software error", "power it off and on"},
    {0x7000, 0xF000, EMERGENCY, "error of an additional module", "check sensors and brake"},
    {0x8000, 0xF000, EMERGENCY, "monitoring error", "check the drive's manual"},
    {0x0000, 0x0000, EMERGENCY, "emergency", "look the code up in the drive's manual"},
};

const struct gn_emergency_words *gn_emergency_of(uint16_t code) {
    const struct gn_emergency_words *entry = table;
    while ((code & entry->mask) != entry->code) {
        entry++;
    }
    return entry;
}
