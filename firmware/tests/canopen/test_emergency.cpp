// test_emergency.cpp: EMCY codes in words, the most special one first.
#include <gtest/gtest.h>

extern "C" {
#include "emergency.h"
}

namespace {

TEST(Emergency, names_the_common_codes) {
    struct {
        std::uint16_t code;
        const char *words;
    } const table[] = {
        {0x8611, "following error"},       {0x7305, "encoder 1 error"},
        {0x7320, "position sensor error"}, {0x3210, "DC link over-voltage"},
        {0x3220, "DC link under-voltage"}, {0x4210, "drive too hot"},
        {0x5112, "drive hardware error"},  {0x8130, "the firmware's heartbeat was missed"},
        {0x8250, "RPDO time-out"},         {0x3130, "voltage error"},
        {0x8FFF, "monitoring error"},      {0xFF01, "emergency"},
    };
    for (const auto &row : table) {
        EXPECT_STREQ(gn_emergency_of(row.code)->words, row.words) << std::hex << row.code;
    }
    EXPECT_EQ(gn_emergency_of(0x8611)->fault, gonio_FaultCode_FAULT_FOLLOWING_ERROR);
    EXPECT_EQ(gn_emergency_of(0x7305)->fault, gonio_FaultCode_FAULT_EMERGENCY);
}

} // namespace
