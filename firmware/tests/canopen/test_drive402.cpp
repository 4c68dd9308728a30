// test_drive402.cpp: the power state machine against the tables of CiA 402 (IEC 61800-7-201, 6.4).
#include <gtest/gtest.h>

extern "C" {
#include "drive402.h"
}

namespace {

TEST(Drive402, decodes_the_standard_statuswords_whatever_the_other_bits) {
    struct {
        std::uint16_t bits, care;
        gn_drive_state state;
    } const table[] = {
        {0x00, 0x4F, GN_DRIVE_NOT_READY},          {0x40, 0x4F, GN_DRIVE_SWITCH_ON_DISABLED},
        {0x21, 0x6F, GN_DRIVE_READY_TO_SWITCH_ON}, {0x23, 0x6F, GN_DRIVE_SWITCHED_ON},
        {0x27, 0x6F, GN_DRIVE_OPERATION_ENABLED},  {0x07, 0x6F, GN_DRIVE_QUICK_STOP_ACTIVE},
        {0x0F, 0x4F, GN_DRIVE_FAULT_REACTION},     {0x08, 0x4F, GN_DRIVE_FAULT},
    };
    for (std::uint32_t word = 0; word <= 0xFFFF; word++) {
        gn_drive_state expected = GN_DRIVE_UNKNOWN;
        for (const auto &row : table) {
            if ((word & row.care) == row.bits) {
                expected = row.state;
            }
        }
        ASSERT_EQ(gn_drive_state_of(static_cast<std::uint16_t>(word)), expected) << word;
    }
}

struct Row {
    gn_drive_goal goal;
    gn_drive_state from;
    std::uint32_t number;
    std::uint16_t controlword;
};

// Transition numbers and commands of the standard: 2 shutdown, 3 switch on, 4 enable operation, 5 disable operation,
// 6 shutdown, 7 and 12 disable voltage, 10 and 11 quick stop, 15 fault reset, 16 enable operation.
constexpr Row standard[] = {
    {GN_GOAL_ENABLED, GN_DRIVE_SWITCH_ON_DISABLED, 2, 0x06},
    {GN_GOAL_ENABLED, GN_DRIVE_READY_TO_SWITCH_ON, 3, 0x07},
    {GN_GOAL_ENABLED, GN_DRIVE_SWITCHED_ON, 4, 0x0F},
    {GN_GOAL_ENABLED, GN_DRIVE_QUICK_STOP_ACTIVE, 16, 0x0F},
    {GN_GOAL_ENABLED, GN_DRIVE_FAULT, 15, 0x80},
    {GN_GOAL_QUICK_STOP, GN_DRIVE_READY_TO_SWITCH_ON, 7, 0x02},
    {GN_GOAL_QUICK_STOP, GN_DRIVE_SWITCHED_ON, 10, 0x02},
    {GN_GOAL_QUICK_STOP, GN_DRIVE_OPERATION_ENABLED, 11, 0x02},
    {GN_GOAL_RELEASED, GN_DRIVE_OPERATION_ENABLED, 5, 0x07},
    {GN_GOAL_RELEASED, GN_DRIVE_SWITCHED_ON, 6, 0x06},
    {GN_GOAL_RELEASED, GN_DRIVE_READY_TO_SWITCH_ON, 7, 0x00},
    {GN_GOAL_RELEASED, GN_DRIVE_QUICK_STOP_ACTIVE, 12, 0x00},
    {GN_GOAL_RELEASED, GN_DRIVE_FAULT, 15, 0x80},
    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_OPERATION_ENABLED, 11, 0x02},
    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_QUICK_STOP_ACTIVE, 12, 0x00},
    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_SWITCHED_ON, 10, 0x00},
    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_READY_TO_SWITCH_ON, 7, 0x00},
    {GN_GOAL_RELEASED_BY_STOP, GN_DRIVE_FAULT, 15, 0x80},
};

TEST(Drive402, commands_every_transition_of_the_standard_and_no_other) {
    for (int goal = GN_GOAL_NONE; goal <= GN_GOAL_RELEASED_BY_STOP; goal++) {
        for (int from = GN_DRIVE_UNKNOWN; from <= GN_DRIVE_FAULT; from++) {
            const Row *row = nullptr;
            for (const Row &candidate : standard) {
                if (candidate.goal == goal && candidate.from == from) {
                    row = &candidate;
                }
            }
            const gn_drive_transition *found =
                gn_drive_transition_to(static_cast<gn_drive_goal>(goal), static_cast<gn_drive_state>(from));
            ASSERT_EQ(found != nullptr, row != nullptr) << goal << " from " << from;
            if (row != nullptr) {
                EXPECT_EQ(found->number, row->number);
                EXPECT_EQ(found->controlword, row->controlword);
            }
        }
    }
}

TEST(Drive402, resets_a_fault_with_rising_edges) {
    gn_drive drive{};
    drive.seen = true;
    drive.goal = GN_GOAL_ENABLED;
    drive.statusword = 0x0008;
    drive.controlword = 0x0F;
    EXPECT_EQ(gn_drive_command(&drive), 0x80);
    EXPECT_EQ(gn_drive_command(&drive), 0x00);
    EXPECT_EQ(gn_drive_command(&drive), 0x80);
}

TEST(Drive402, waits_in_states_that_the_drive_leaves_by_itself) {
    for (std::uint16_t const status : {0x0000, 0x000F}) {
        gn_drive drive{};
        drive.seen = true;
        drive.goal = GN_GOAL_ENABLED;
        drive.statusword = status;
        drive.controlword = 0x06;
        EXPECT_EQ(gn_drive_command(&drive), 0x06);
        EXPECT_FALSE(gn_drive_at_goal(&drive));
    }
}

TEST(Drive402, commands_nothing_before_a_statusword_came) {
    gn_drive drive{};
    drive.goal = GN_GOAL_ENABLED;
    EXPECT_EQ(gn_drive_command(&drive), 0x00);
    EXPECT_FALSE(gn_drive_at_goal(&drive));
}

TEST(Drive402, carries_homing_start_only_while_operation_is_enabled) {
    gn_drive drive{};
    drive.seen = true;
    drive.goal = GN_GOAL_ENABLED;
    drive.operation_bits = GN_CONTROL_HOMING_START;
    drive.statusword = 0x0023;
    EXPECT_EQ(gn_drive_command(&drive), 0x0F);
    drive.statusword = 0x0627;
    EXPECT_EQ(gn_drive_command(&drive), 0x1F);
}

} // namespace
