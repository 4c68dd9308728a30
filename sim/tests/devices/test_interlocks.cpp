// test_interlocks.cpp: the safety chain takes torque and light; the shutter needs command, chain and watchdog.
#include <vector>

#include <gtest/gtest.h>

#include "interlocks.hpp"

namespace gonio::sim {
namespace {

struct Chain {
    std::vector<std::pair<std::uint32_t, bool>> lines;
    std::vector<bool> torque;
    Interlocks interlocks{[this](std::uint32_t line, bool level) { lines.emplace_back(line, level); },
                          [this](bool allowed) { torque.push_back(allowed); }};
};

struct Rig {
    Scheduler scheduler;
    Shutter shutter{scheduler};
    void run_ms(int ms, bool pulsed) {
        for (int i = 0; i < ms; ++i) {
            if (pulsed) {
                shutter.pulse_watchdog();
            }
            std::int64_t const end_ns = scheduler.now_ns() + 1000000;
            while (scheduler.run_one(end_ns)) {
            }
        }
    }
};

} // namespace

TEST(Interlocks, EachOfThemTakesTheTorque) {
    Chain chain;
    chain.interlocks.set_door(false);
    EXPECT_EQ(chain.torque, (std::vector<bool>{false}));
    EXPECT_EQ(chain.lines, (std::vector<std::pair<std::uint32_t, bool>>{{GN_LINE_DOOR, false}, {GN_LINE_STO, false}}));
    EXPECT_FALSE(chain.interlocks.light_allowed());
    chain.interlocks.set_emergency_stop(false);
    chain.interlocks.set_door(true);
    EXPECT_EQ(chain.torque.size(), 1U) << "the emergency stop still holds it off";
    chain.interlocks.set_emergency_stop(true);
    EXPECT_EQ(chain.torque, (std::vector<bool>{false, true}));
    chain.interlocks.set_sto(false);
    EXPECT_TRUE(chain.interlocks.light_allowed());
    EXPECT_FALSE(chain.interlocks.level(GN_LINE_STO));
    EXPECT_TRUE(chain.interlocks.level(GN_LINE_DOOR));
}

TEST(Shutter, OpensAfterItsTravelAndRemembersWhen) {
    Rig rig;
    rig.run_ms(5, true);
    rig.shutter.command(true);
    rig.run_ms(19, true);
    EXPECT_FALSE(rig.shutter.is_open());
    rig.run_ms(2, true);
    EXPECT_TRUE(rig.shutter.is_open());
    rig.shutter.command(false);
    rig.run_ms(30, true);
    EXPECT_FALSE(rig.shutter.is_open());
    EXPECT_FALSE(rig.shutter.was_open(24900000));
    EXPECT_TRUE(rig.shutter.was_open(25100000));
    EXPECT_TRUE(rig.shutter.was_open(45900000));
    EXPECT_FALSE(rig.shutter.was_open(46100000));
}

TEST(Shutter, SpringClosesItWithoutWatchdogAndWhenNotAllowed) {
    Rig rig;
    rig.shutter.command(true);
    rig.run_ms(50, false);
    EXPECT_FALSE(rig.shutter.is_open()) << "nobody pulses the watchdog";
    rig.run_ms(50, true);
    EXPECT_TRUE(rig.shutter.is_open());
    rig.run_ms(98, false);
    EXPECT_TRUE(rig.shutter.is_open());
    rig.run_ms(24, false);
    EXPECT_FALSE(rig.shutter.is_open());
    EXPECT_EQ(rig.shutter.watchdog_trips(), 1U);
    rig.run_ms(50, true);
    EXPECT_TRUE(rig.shutter.is_open());
    rig.shutter.allow(false);
    rig.run_ms(25, true);
    EXPECT_FALSE(rig.shutter.is_open());
}

TEST(Interlocks, TheLimitLineIsOnlyALine) {
    Chain chain;
    EXPECT_TRUE(chain.interlocks.level(GN_LINE_LIMIT));
    chain.interlocks.set_limit(false);
    EXPECT_EQ(chain.lines, (std::vector<std::pair<std::uint32_t, bool>>{{GN_LINE_LIMIT, false}}));
    EXPECT_TRUE(chain.torque.empty()) << "it stops nothing by itself";
    chain.interlocks.set_limit(true);
    EXPECT_TRUE(chain.interlocks.level(GN_LINE_LIMIT));
}

} // namespace gonio::sim
