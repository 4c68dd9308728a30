// test_state402.cpp: every transition of CiA 402-2, by number, and the commands that must do nothing.
#include <gtest/gtest.h>

#include <array>

#include "state402.hpp"

namespace gonio::sim {
namespace {

constexpr std::uint16_t shutdown = 0x06, switch_on = 0x07, enable = 0x0F, disable_voltage = 0x00, quick_stop = 0x02,
                        fault_reset = 0x80;
const Stop_options options; // quick stop ramp, then switch on disabled; disable with ramp; fault with ramp

State402 in(Drive_state wanted, const Stop_options &with = options) {
    State402 machine;
    machine.power_up();
    const auto command = [&](std::uint16_t word) { machine.command(word, true, with); };
    switch (wanted) {
    case Drive_state::switch_on_disabled:
        break;
    case Drive_state::ready_to_switch_on:
        command(shutdown);
        break;
    case Drive_state::switched_on:
        command(shutdown);
        command(switch_on);
        break;
    case Drive_state::operation_enabled:
    case Drive_state::quick_stop_active:
    case Drive_state::fault_reaction_active:
    case Drive_state::fault:
        command(shutdown);
        command(switch_on);
        command(enable);
        if (wanted == Drive_state::quick_stop_active) {
            command(quick_stop);
        } else if (wanted != Drive_state::operation_enabled) {
            machine.fault(true, with);
            if (wanted == Drive_state::fault) {
                machine.ramp_finished();
            }
        }
        break;
    }
    EXPECT_EQ(machine.state(), wanted);
    return machine;
}

Drive_state after(Drive_state from, std::uint16_t controlword) {
    State402 machine = in(from);
    machine.command(controlword, true, options);
    return machine.state();
}

TEST(State402, commands_lead_where_the_standards_table_says) {
    using enum Drive_state;
    struct Row {
        Drive_state from;
        std::array<Drive_state, 6> to; // shutdown, switch on, enable, disable voltage, quick stop, fault reset
    };
    // disable operation (0x07 from operation enabled) ends in switched on only when the axis is at rest.
    const std::array<Row, 7> table{{
        {switch_on_disabled,
         {ready_to_switch_on, switch_on_disabled, switch_on_disabled, switch_on_disabled, switch_on_disabled,
          switch_on_disabled}},
        {ready_to_switch_on,
         {ready_to_switch_on, switched_on, operation_enabled, switch_on_disabled, switch_on_disabled,
          ready_to_switch_on}},
        {switched_on,
         {ready_to_switch_on, switched_on, operation_enabled, switch_on_disabled, switch_on_disabled, switched_on}},
        {operation_enabled,
         {ready_to_switch_on, operation_enabled, operation_enabled, switch_on_disabled, quick_stop_active,
          operation_enabled}},
        {quick_stop_active,
         {quick_stop_active, quick_stop_active, quick_stop_active, switch_on_disabled, quick_stop_active,
          quick_stop_active}},
        {fault_reaction_active,
         {fault_reaction_active, fault_reaction_active, fault_reaction_active, fault_reaction_active,
          fault_reaction_active, fault_reaction_active}},
        {fault, {fault, fault, fault, fault, fault, switch_on_disabled}},
    }};
    const std::array<std::uint16_t, 6> commands{shutdown, switch_on, enable, disable_voltage, quick_stop, fault_reset};
    for (const Row &row : table) {
        for (std::size_t k = 0; k < commands.size(); ++k) {
            EXPECT_EQ(after(row.from, commands[k]), row.to[k])
                << "from state " << static_cast<int>(row.from) << " by controlword " << commands[k];
        }
    }
}

TEST(State402, statuswords_are_those_of_the_standard) {
    using enum Drive_state;
    EXPECT_EQ(in(switch_on_disabled).status_bits(), 0x40);
    EXPECT_EQ(in(ready_to_switch_on).status_bits(), 0x21);
    EXPECT_EQ(in(switched_on).status_bits(), 0x23);
    EXPECT_EQ(in(operation_enabled).status_bits(), 0x27);
    EXPECT_EQ(in(quick_stop_active).status_bits(), 0x07);
    EXPECT_EQ(in(fault_reaction_active).status_bits(), 0x0F);
    EXPECT_EQ(in(fault).status_bits(), 0x08);
}

TEST(State402, disable_operation_slows_down_first_or_at_once_and_can_be_taken_back) {
    State402 machine = in(Drive_state::operation_enabled);
    machine.command(switch_on, true, options);
    EXPECT_EQ(machine.state(), Drive_state::operation_enabled);
    EXPECT_EQ(machine.ramp(), Stop_ramp::slow_down);
    EXPECT_FALSE(machine.follows());
    machine.command(enable, true, options);
    EXPECT_TRUE(machine.follows());
    machine.command(switch_on, true, options);
    machine.ramp_finished();
    EXPECT_EQ(machine.state(), Drive_state::switched_on); // 5

    Stop_options at_once;
    at_once.disable_operation = 0;
    State402 other = in(Drive_state::operation_enabled);
    other.command(switch_on, true, at_once);
    EXPECT_EQ(other.state(), Drive_state::switched_on);
}

TEST(State402, quick_stop_options_choose_ramp_and_end) {
    struct Row {
        std::int64_t option;
        Stop_ramp ramp;
        Drive_state at_once, at_rest, after_enable;
    };
    using enum Drive_state;
    for (const Row &row : {Row{0, Stop_ramp::none, switch_on_disabled, switch_on_disabled, switch_on_disabled},
                           Row{1, Stop_ramp::slow_down, quick_stop_active, switch_on_disabled, switch_on_disabled},
                           Row{2, Stop_ramp::quick_stop, quick_stop_active, switch_on_disabled, switch_on_disabled},
                           Row{5, Stop_ramp::slow_down, quick_stop_active, quick_stop_active, operation_enabled},
                           Row{6, Stop_ramp::quick_stop, quick_stop_active, quick_stop_active, operation_enabled}}) {
        Stop_options with;
        with.quick_stop = row.option;
        State402 machine = in(operation_enabled);
        machine.command(quick_stop, true, with);
        EXPECT_EQ(machine.ramp(), row.ramp) << row.option;
        EXPECT_EQ(machine.state(), row.at_once) << row.option;
        machine.ramp_finished();
        EXPECT_EQ(machine.state(), row.at_rest) << row.option;
        machine.command(enable, true, with); // 16
        EXPECT_EQ(machine.state(), row.after_enable) << row.option;
    }
}

TEST(State402, fault_reaction_stops_with_the_ramp_of_its_option) {
    for (const auto &[option, ramp, state] :
         {std::tuple{0, Stop_ramp::none, Drive_state::fault},
          std::tuple{1, Stop_ramp::slow_down, Drive_state::fault_reaction_active},
          std::tuple{2, Stop_ramp::quick_stop, Drive_state::fault_reaction_active}}) {
        Stop_options with;
        with.fault_reaction = option;
        State402 machine = in(Drive_state::operation_enabled);
        machine.fault(true, with);
        EXPECT_EQ(machine.state(), state);
        EXPECT_EQ(machine.ramp(), ramp);
    }
    State402 without_torque = in(Drive_state::operation_enabled);
    without_torque.fault(false, options);
    EXPECT_EQ(without_torque.state(), Drive_state::fault);
    State402 at_rest = in(Drive_state::switched_on);
    at_rest.fault(true, options);
    EXPECT_EQ(at_rest.state(), Drive_state::fault);
}

TEST(State402, fault_reset_needs_a_rising_edge) {
    State402 machine;
    machine.power_up();
    machine.command(fault_reset, true, options);
    machine.fault(true, options);
    machine.command(fault_reset, true, options); // still set from before
    EXPECT_EQ(machine.state(), Drive_state::fault);
    machine.command(0, true, options);
    machine.command(fault_reset, true, options); // 15
    EXPECT_EQ(machine.state(), Drive_state::switch_on_disabled);
    EXPECT_TRUE(machine.take_fault_reset());
    EXPECT_FALSE(machine.take_fault_reset());
}

TEST(State402, without_permission_for_torque_neither_2_nor_15_happens) {
    State402 machine;
    machine.power_up();
    machine.command(shutdown, false, options);
    EXPECT_EQ(machine.state(), Drive_state::switch_on_disabled);
    State402 faulty = in(Drive_state::fault);
    faulty.command(fault_reset, false, options);
    EXPECT_EQ(faulty.state(), Drive_state::fault);
}

} // namespace
} // namespace gonio::sim
