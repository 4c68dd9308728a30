// test_inputs.cpp: the limit line, and edges that were lost: no state of a line is missed.
#include "bench.hpp"

namespace gonio::test {
namespace {

struct Inputs : testing::Test {
    Bench bench;

    void SetUp() override { ASSERT_NO_FATAL_FAILURE(bench.make_ready()); }
    void move() {
        bench.begin_move(1, 60000, 6.0);
        bench.run(2000 * ms);
        ASSERT_EQ(bench.motion->state, gonio_InstrumentState_STATE_MOVING);
    }
    void lose_edges(std::uint32_t line, std::uint32_t count) { bench.edge_numbers[line] += count; }
};

TEST_F(Inputs, limit_switch_stops_a_path_and_homing_leads_off_it) {
    move();
    bench.edge(GN_LINE_LIMIT, false);
    bench.run(3000 * ms);
    gonio_Fault const fault = bench.only_fault();
    EXPECT_EQ(fault.code, gonio_FaultCode_FAULT_LIMIT);
    EXPECT_STREQ(fault.sentence, "a limit switch was reached; position unknown; check min_deg, max_deg and the sign of "
                                 "counts_per_deg, then clear the fault and home");
    EXPECT_EQ(bench.motion->inputs, 0x7u);
    bench.request(gonio_Request_clear_fault_tag);
    bench.run(500 * ms);
    bench.request(gonio_Request_boot_tag);
    bench.run(1000 * ms);
    bench.home();
    bench.run(1000 * ms);
    ASSERT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
    std::uint32_t const held = bench.begin_move(2, 100, 1.0);
    bench.run(10 * ms);
    EXPECT_STREQ(bench.reply(held)->text, "a limit switch is reached: home to leave it");
    bench.edge(GN_LINE_LIMIT, true);
    bench.begin_move(3, 100, 1.0);
    bench.run(2000 * ms);
    EXPECT_EQ(bench.last_path_end(), gonio_PathEnd_PATH_FINISHED);
}

TEST_F(Inputs, limit_switch_is_meant_to_be_reached_in_homing) {
    bench.home();
    bench.run(100 * ms);
    bench.edge(GN_LINE_LIMIT, false);
    bench.run(50 * ms);
    bench.edge(GN_LINE_LIMIT, true);
    bench.run(1000 * ms);
    EXPECT_EQ(bench.motion->state, gonio_InstrumentState_STATE_READY);
    EXPECT_TRUE(bench.all(gonio_Event_fault_tag).empty());
}

TEST_F(Inputs, emergency_stop_is_named_though_the_torque_went_first) {
    move();
    bench.levels[GN_LINE_EMERGENCY_STOP] = false; // its own edge is still on the way
    bench.edge(GN_LINE_STO, false);
    bench.run(1 * ms);
    bench.edge(GN_LINE_EMERGENCY_STOP, false);
    bench.run(3000 * ms);
    EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_EMERGENCY_STOP);
}

TEST_F(Inputs, torque_that_went_alone_is_told_as_that) {
    move();
    bench.edge(GN_LINE_STO, false);
    bench.run(3000 * ms);
    EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_STO);
}

TEST_F(Inputs, door_that_opened_and_closed_unseen_is_a_fault) {
    move();
    lose_edges(GN_LINE_DOOR, 1); // it fell, and this is where it rose again
    bench.edge(GN_LINE_DOOR, true);
    bench.run(3000 * ms);
    EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_DOOR);
    EXPECT_EQ(bench.motion->inputs & 1u, 1u);
    EXPECT_EQ(bench.shared.counters.edges_lost, 1u);
}

TEST_F(Inputs, level_is_read_anew_after_a_lost_edge) {
    lose_edges(GN_LINE_STO, 1);
    bench.edge(GN_LINE_STO, true);
    bench.levels[GN_LINE_STO] = false; // and it has fallen since
    bench.run(10 * ms);
    EXPECT_EQ(bench.motion->inputs & 4u, 0u);
    EXPECT_EQ(bench.only_fault().code, gonio_FaultCode_FAULT_STO);
    EXPECT_FALSE(bench.all(gonio_Event_input_tag).back().body.input.level);
}

TEST_F(Inputs, numbers_that_run_on_lose_nothing) {
    for (bool const level : {false, true, false, true}) {
        bench.edge(GN_LINE_LIMIT, level);
    }
    bench.run(10 * ms);
    EXPECT_EQ(bench.shared.counters.edges_lost, 0u);
    EXPECT_TRUE(bench.all(gonio_Event_fault_tag).empty());
}

} // namespace
} // namespace gonio::test
