/* sdo_words.c: SDO abort codes (CiA 301, table 22) in words. */
#include <stddef.h>

#include "sdo.h"

static const struct {
    uint32_t code;
    const char *words;
} aborts[] = {
    {0x05030000, "toggle bit not alternated"},
    {0x05040000, "SDO protocol timed out"},
    {0x05040001, "command specifier not valid"},
    {0x05040002, "invalid block size"},
    {0x05040003, "invalid sequence number"},
    {0x05040004, "CRC error"},
    {0x05040005, "out of memory"},
    {0x06010000, "unsupported access"},
    {0x06010001, "object is write only"},
    {0x06010002, "object is read only"},
    {0x06020000, "object does not exist"},
    {0x06040041, "object cannot be mapped to the PDO"},
    {0x06040042, "mapped objects exceed the PDO's length"},
    {0x06040043, "general parameter incompatibility"},
    {0x06040047, "general internal incompatibility"},
    {0x06060000, "hardware error"},
    {0x06070010, "length does not match"},
    {0x06070012, "length too high"},
    {0x06070013, "length too low"},
    {0x06090011, "subindex does not exist"},
    {0x06090030, "value out of range"},
    {0x06090031, "value too high"},
    {0x06090032, "value too low"},
    {0x06090036, "maximum is less than minimum"},
    {0x060A0023, "resource not available"},
    {0x08000000, "general error"},
    {0x08000020, "data cannot be stored"},
    {0x08000021, "data cannot be stored: local control"},
    {0x08000022, "data cannot be stored in this device state"},
    {0x08000023, "no object dictionary"},
    {0x08000024, "no data available"},
};

const char *gn_sdo_abort_words(uint32_t code) {
    for (size_t i = 0; i < sizeof aborts / sizeof aborts[0]; i++) {
        if (aborts[i].code == code) {
            return aborts[i].words;
        }
    }
    return "abort code unknown to the standard";
}
