// test_transitions.cpp: the 17 transitions of the CiA 402 power state machine (IEC 61800-7-201, 6.4), played by a drive
// that knows nothing but the standard's table: which of them each goal takes, and what is made of the others.
#include <set>

#include "bench.hpp"

namespace gonio::test {
namespace {

// Statuswords of the states, without the bits that do not matter.
constexpr std::uint16_t not_ready = 0x00, disabled = 0x40, ready = 0x21, switched_on = 0x23, enabled = 0x27,
                        quick_stop = 0x07, reaction = 0x0F, fault = 0x08;

struct Command {
    std::uint16_t mask, value; // of the controlword; a mask of 0: the drive does it by itself
};
constexpr Command by_itself = {0, 0}, shutdown = {0x87, 0x06}, switch_on = {0x8F, 0x07}, enable = {0x8F, 0x0F},
                  disable_voltage = {0x82, 0x00}, stop_quickly = {0x86, 0x02}, fault_reset = {0x80, 0x80};

struct Transition {
    int number;
    std::uint16_t from, to;
    std::vector<Command> commands;
};

const std::vector<Transition> &standard() {
    static std::vector<Transition> const table = {
        {1, not_ready, disabled, {by_itself}},
        {2, disabled, ready, {shutdown}},
        {3, ready, switched_on, {switch_on, enable}}, // enable: with 4 right behind it
        {4, switched_on, enabled, {enable}},
        {5, enabled, switched_on, {switch_on}},
        {6, switched_on, ready, {shutdown}},
        {7, ready, disabled, {disable_voltage, stop_quickly}},
        {8, enabled, ready, {shutdown}},
        {9, enabled, disabled, {disable_voltage}},
        {10, switched_on, disabled, {disable_voltage, stop_quickly}},
        {11, enabled, quick_stop, {stop_quickly}},
        {12, quick_stop, disabled, {disable_voltage}},
        {14, reaction, fault, {by_itself}},
        {15, fault, disabled, {fault_reset}}, // on the rising edge
        {16, quick_stop, enabled, {enable}},
    }; // 0 (power-up to not ready) and 13 (to fault reaction, from anywhere) begin in no state
    return table;
}

// The transitions that a drive of the standard takes from here under this goal; `drive` ends where it comes to rest.
std::vector<int> play(gn_drive_goal goal, std::uint16_t status, gn_drive &drive) {
    std::vector<int> taken;
    drive = {};
    drive.seen = true;
    drive.goal = goal;
    drive.statusword = status;
    std::uint16_t before = 0;
    for (int cycle = 0; cycle < 20; cycle++) {
        std::uint16_t const word = gn_drive_command(&drive);
        for (const Transition &t : standard()) {
            bool const obeyed = std::any_of(t.commands.begin(), t.commands.end(), [&](const Command &c) {
                return (word & c.mask) == c.value && !(c.mask == 0x80 && (before & 0x80));
            });
            if (t.from == drive.statusword && obeyed) {
                taken.push_back(t.number);
                drive.statusword = t.to;
                break;
            }
        }
        before = word;
    }
    return taken;
}

TEST(Transitions, each_goal_is_reached_from_every_state_by_the_standards_way) {
    struct {
        gn_drive_goal goal;
        std::uint16_t from;
        std::vector<int> way;
        std::uint16_t end;
    } const cases[] = {
        {GN_GOAL_ENABLED, not_ready, {1, 2, 3, 4}, enabled},
        {GN_GOAL_ENABLED, disabled, {2, 3, 4}, enabled},
        {GN_GOAL_ENABLED, ready, {3, 4}, enabled},
        {GN_GOAL_ENABLED, switched_on, {4}, enabled},
        {GN_GOAL_ENABLED, enabled, {}, enabled},
        {GN_GOAL_ENABLED, quick_stop, {16}, enabled},
        {GN_GOAL_ENABLED, reaction, {14, 15, 2, 3, 4}, enabled},
        {GN_GOAL_ENABLED, fault, {15, 2, 3, 4}, enabled},
        {GN_GOAL_QUICK_STOP, enabled, {11}, quick_stop},
        {GN_GOAL_QUICK_STOP, switched_on, {10}, disabled},
        {GN_GOAL_QUICK_STOP, ready, {7}, disabled},
        {GN_GOAL_QUICK_STOP, disabled, {}, disabled},
        {GN_GOAL_QUICK_STOP, quick_stop, {}, quick_stop},
        {GN_GOAL_RELEASED, enabled, {5, 6, 7}, disabled},
        {GN_GOAL_RELEASED, switched_on, {6, 7}, disabled},
        {GN_GOAL_RELEASED, ready, {7}, disabled},
        {GN_GOAL_RELEASED, quick_stop, {12}, disabled},
        {GN_GOAL_RELEASED, reaction, {14, 15}, disabled},
        {GN_GOAL_RELEASED, fault, {15}, disabled},
        {GN_GOAL_RELEASED_BY_STOP, enabled, {11, 12}, disabled},
        {GN_GOAL_RELEASED_BY_STOP, switched_on, {10}, disabled},
        {GN_GOAL_RELEASED_BY_STOP, ready, {7}, disabled},
        {GN_GOAL_RELEASED_BY_STOP, quick_stop, {12}, disabled},
        {GN_GOAL_RELEASED_BY_STOP, fault, {15}, disabled},
    };
    std::set<int> taken;
    for (const auto &c : cases) {
        gn_drive drive{};
        std::vector<int> const way = play(c.goal, c.from, drive);
        EXPECT_EQ(way, c.way) << "goal " << c.goal << " from " << c.from;
        EXPECT_EQ(drive.statusword, c.end);
        EXPECT_TRUE(gn_drive_at_goal(&drive)) << "goal " << c.goal << " from " << c.from;
        taken.insert(way.begin(), way.end());
    }
    // All but power-up, those that take the torque from a moving axis, and the drive's own fault: see below.
    EXPECT_EQ(taken, (std::set<int>{1, 2, 3, 4, 5, 6, 7, 10, 11, 12, 14, 15, 16}));
}

TEST(Transitions, faults_without_a_goal_are_left_alone) {
    for (std::uint16_t const from : {not_ready, disabled, ready, switched_on, quick_stop, reaction, fault}) {
        gn_drive drive{};
        drive.seen = true;
        drive.statusword = from;
        drive.controlword = 0x06;
        EXPECT_EQ(gn_drive_command(&drive), 0x06);
        EXPECT_TRUE(gn_drive_at_goal(&drive));
    }
}

// 5, 8, 9 and 13 when nobody asked for them: the drive was enabled and is not any more.
TEST(Transitions, drive_that_takes_one_by_itself_is_a_fault_that_names_the_state) {
    struct {
        int number;
        std::uint16_t to;
        const char *words;
    } const cases[] = {{5, switched_on, "switched on"},         {8, ready, "ready to switch on"},
                       {9, disabled, "switch on disabled"},     {11, quick_stop, "quick stop active"},
                       {13, reaction, "fault reaction active"}, {14, fault, "fault"}};
    for (const auto &c : cases) {
        Bench bench;
        ASSERT_NO_FATAL_FAILURE(bench.make_ready());
        bool once = true;
        bench.meddle = [&](gn_can_frame &frame, std::int64_t &) {
            if (frame.id == 0x183 && once) {
                frame.data[0] = static_cast<std::uint8_t>(c.to);
                once = false;
            }
            return false;
        };
        bench.run(20 * ms);
        gonio_Fault const told = bench.only_fault();
        EXPECT_EQ(told.code, gonio_FaultCode_FAULT_DRIVE_STATE) << c.number;
        char words[120];
        std::snprintf(words, sizeof words,
                      "arm azimuth (node 3): left operation enabled, 0x6041 (statusword) 0x%04X: %s;", c.to, c.words);
        EXPECT_EQ(std::string(told.sentence).find(words), 0u) << c.number << ": " << told.sentence;
        EXPECT_EQ(bench.motion->axes[2].drive.goal, GN_GOAL_QUICK_STOP);
    }
}

// 0: a drive that is switched on begins here; boot waits for it without commanding anything.
TEST(Transitions, power_up_is_waited_for) {
    EXPECT_EQ(gn_drive_state_of(not_ready), GN_DRIVE_NOT_READY);
    EXPECT_STREQ(gn_drive_state_words(GN_DRIVE_NOT_READY), "not ready to switch on");
    EXPECT_EQ(gn_drive_transition_to(GN_GOAL_ENABLED, GN_DRIVE_NOT_READY), nullptr);
    EXPECT_EQ(gn_drive_state_of(0x2F), GN_DRIVE_FAULT_REACTION); // bit 5 says nothing in a fault
    EXPECT_STREQ(gn_drive_state_words(gn_drive_state_of(0x01)), "in no state of the standard");
}

} // namespace
} // namespace gonio::test
