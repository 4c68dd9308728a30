// test_run.cpp: the twin's main loop with a host in another thread that keeps step, hangs up, is silenced, or says
// nothing.
#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "frame_scanner.hpp"
#include "run.hpp"
#include "scripted_host.hpp"

namespace gonio::sim {
namespace {

Scenario scenario_with(std::vector<Fault> faults) {
    Scenario scenario = load_scenario(GONIO_SOURCE_DIR "/sim/scenarios/lambertian.toml", GONIO_SOURCE_DIR);
    scenario.faults = std::move(faults);
    return scenario;
}

// Says at the second look that ten seconds of wall time went into light since the first.
class Slow_optics final : public Optics {
public:
    [[nodiscard]] double apparent_dsf_per_sr(const Reading &) const override { return 0.0; }
    [[nodiscard]] std::int64_t held_ns() const override { return looks_++ == 0 ? 0 : 10000000000; }

private:
    mutable int looks_ = 0;
};

// Says HELLO and IDLE to every frame, until it has had `frames` of them or the twin closes; how many it had.
std::uint32_t keep_step(Host &host, std::uint32_t frames) {
    host.say(hello(gonio_Role_ROLE_DRIVER));
    Frame_scanner scanner;
    std::uint32_t last = 0;
    for (Bytes bytes = host.hear_bytes(); !bytes.empty() && last < frames; bytes = host.hear_bytes()) {
        scanner.feed(bytes.data(), bytes.size(), [&](const gn_frame_header &header, const std::uint8_t *) {
            last = std::max<std::uint32_t>(last, header.sequence);
        });
        if (last < frames) {
            host.say(frame(GN_FRAME_IDLE, 0, last));
        } else {
            host.hang_up();
        }
    }
    return last;
}

} // namespace

TEST(Run, EndsWhenTheDriverHasGone) {
    Lockstep_link link("127.0.0.1", 0, false);
    World world(scenario_with({}), link, {});
    std::atomic<bool> const ended{false};
    std::thread host_thread([&link] {
        Host host(link);
        EXPECT_EQ(keep_step(host, 25), 25U);
    });
    EXPECT_EQ(run_virtual(world, link, 30.0, ended), "driver gone, at rest and dark");
    host_thread.join();
    // Twenty-five frames, at most eleven a second (ten Status, one Counters): time did not run away from the host.
    EXPECT_GE(world.scheduler().now_ns(), 2000000000);
    EXPECT_LT(world.scheduler().now_ns(), 3000000000);
}

TEST(Run, ASilencedHostReleasesTheClock) {
    Lockstep_link link("127.0.0.1", 0, false);
    Fault silence{};
    silence.kind = Fault_kind::host_silent;
    silence.at_s = 0.55;
    std::thread host_thread;
    {
        World world(scenario_with({silence}), link, {});
        std::atomic<bool> const ended{false};
        host_thread = std::thread([&link] {
            Host host(link);
            EXPECT_GE(keep_step(host, UINT32_MAX), 5U);
        });
        EXPECT_EQ(run_virtual(world, link, 30.0, ended), "driver gone, at rest and dark");
        EXPECT_LT(world.scheduler().now_ns(), 1000000000);
    }
    link.close(0);
    host_thread.join();
}

// In real time the clock stands while light is traced, or the firmware would take it for a host that is silent. It is
// ten seconds behind after a round, so in the next 0.3 s nothing happens; a clock that went on would show them.
TEST(Run, ThePacedClockStandsWhileLightIsTraced) {
    Lockstep_link link("127.0.0.1", 0, true);
    World world(scenario_with({}), link, {}, [](const Scenario &) { return std::make_unique<Slow_optics>(); });
    std::atomic<bool> ended{false};
    std::thread end_thread([&ended] {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        ended = true;
    });
    EXPECT_EQ(run_paced(world, link, ended), "ended by a signal");
    end_thread.join();
    EXPECT_LT(world.scheduler().now_ns(), 150000000);
}

TEST(Run, StallsWithTheNameOfTheOneWhoSaysNothing) {
    Lockstep_link link("127.0.0.1", 0, false);
    World world(scenario_with({}), link, {});
    std::atomic<bool> const ended{false};
    Host const mute(link);
    try {
        run_virtual(world, link, 0.05, ended);
        FAIL() << "nobody said HELLO";
    } catch (const Stalled &stalled) {
        EXPECT_NE(std::string(stalled.what()).find("has not said HELLO"), std::string::npos) << stalled.what();
    }
}

} // namespace gonio::sim
