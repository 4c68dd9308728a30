// test_world.cpp: whole runs of firmware and twin: boot, homing, flight; their figures, their faults and their
// repeatability.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bench_host.hpp"
#include "truth_file.hpp"
#include "world.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t longest_ns = 600000000000;

Scenario scenario_of(const std::string &name) {
    return load_scenario(GONIO_SOURCE_DIR "/sim/scenarios/" + name + ".toml", GONIO_SOURCE_DIR);
}

Bench_result fly(const Scenario &scenario, std::uint64_t samples) {
    Bench_host host(scenario.instrument, samples);
    World world(scenario, host, {});
    host.connect(world);
    while (!host.finished() && world.scheduler().run_one(longest_ns)) {
    }
    return host.result();
}

std::uint64_t hash_of_another_process(const Scenario &scenario, std::uint64_t samples) {
    int ends[2] = {-1, -1};
    if (pipe(ends) != 0) {
        return 0;
    }
    pid_t const child = fork();
    if (child == 0) {
        std::uint64_t const hash = fly(scenario, samples).payload_hash;
        bool const sent = write(ends[1], &hash, sizeof hash) == static_cast<ssize_t>(sizeof hash);
        _exit(sent ? 0 : 1);
    }
    ::close(ends[1]);
    std::uint64_t hash = 0;
    if (read(ends[0], &hash, sizeof hash) != static_cast<ssize_t>(sizeof hash)) {
        hash = 0;
    }
    ::close(ends[0]);
    waitpid(child, nullptr, 0);
    return hash;
}

} // namespace

TEST(World, SameSeedGivesTheSamePayloadInThisProcessAndInAnother) {
    Scenario scenario = scenario_of("demo");
    Bench_result const first = fly(scenario, 4000);
    EXPECT_EQ(first.trouble, "");
    EXPECT_TRUE(first.finished);
    EXPECT_EQ(fly(scenario, 4000).payload_hash, first.payload_hash);
    EXPECT_EQ(hash_of_another_process(scenario, 4000), first.payload_hash);
    scenario.seed += 1;
    EXPECT_NE(fly(scenario, 4000).payload_hash, first.payload_hash);
}

TEST(World, EveryPersonalityFlies) {
    for (const std::string name : {"lambertian", "basic_drives", "fixed_drives"}) {
        Bench_result const result = fly(scenario_of(name), 4000);
        EXPECT_EQ(result.trouble, "") << name;
        EXPECT_GE(result.samples - result.samples_before_flight, 3900U) << name;
        EXPECT_EQ(result.poses_valid, result.poses) << name;
        EXPECT_EQ(result.counters.samples_lost + result.counters.strobes_lost + result.counters.sync_echoes_lost, 0U)
            << name;
    }
}

// The firmware gives such axes a few degrees per second; the bench host wants more on its first path.
TEST(World, DrivesWithoutAnRpdoDeadlineAreNotFlownFast) {
    Scenario scenario = scenario_of("lambertian");
    scenario.drives.without = {{0x1400, 5}};
    EXPECT_NE(fly(scenario, 4000).trouble.find("path 1 ended early"), std::string::npos);
}

TEST(World, LossesAreCountedAndTheFlightGoesOn) {
    Bench_result const result = fly(scenario_of("fault_losses"), 6000);
    EXPECT_EQ(result.trouble, "");
    EXPECT_TRUE(result.finished);
    EXPECT_EQ(result.counters.samples_lost, 50U);
    EXPECT_EQ(result.counters.packets_lost, 1U) << "and none for the counter that wraps";
    EXPECT_EQ(result.counters.sync_echoes_lost, 1U);
    // It comes when the next SYNC has been, so it cannot be told from a second answer to that one; the first is
    // missing.
    EXPECT_EQ(result.counters.tpdo_duplicate, 1U);
    EXPECT_EQ(result.counters.tpdo_missing, 6U)
        << "that one, one of the drive that missed a SYNC, four of the lost SYNC";
    EXPECT_GE(result.counters.strobes_lost, 4U);
    EXPECT_EQ(result.counters.strobes_rejected, 1U);
    // The lost SYNC costs a pose of all axes, the late TPDO and the missed SYNC one axis each.
    EXPECT_LE(result.poses - result.poses_valid, 5U);
    EXPECT_GE(result.poses - result.poses_valid, 3U);
}

TEST(World, FaultsAreToldWithNodeAndCause) {
    std::map<std::string, std::vector<std::string>> const expected = {
        {"fault_node_missing", {"node 3", "boot-up"}},
        {"fault_node_silent", {"node 3", "heartbeat"}},
        {"fault_emcy", {"node 2", "EMCY 0x4310"}},
        {"fault_blocked", {"node 3", "0x6065"}},
        {"fault_door", {"door"}},
        {"fault_emergency_stop", {"emergency stop"}},
        {"fault_sto", {"STO"}},
    };
    for (const auto &[name, words] : expected) {
        std::string const told = fly(scenario_of(name), 6000).trouble;
        for (const std::string &word : words) {
            EXPECT_NE(told.find(word), std::string::npos) << name << ": " << told;
        }
    }
}

TEST(World, ALimitLineThatDropsIsAFault) {
    Scenario scenario = scenario_of("fault_door");
    scenario.faults.at(0).kind = Fault_kind::limit;
    std::string const told = fly(scenario, 6000).trouble;
    EXPECT_NE(told.find("limit"), std::string::npos) << told;
}

TEST(World, AStrobeThatSticksOrDoublesIsCountedAndTheFlightGoesOn) {
    Scenario scenario = scenario_of("fault_door");
    scenario.faults.at(0).kind = Fault_kind::strobe_doubled;
    scenario.faults.at(0).count = 8;
    Bench_result const doubled = fly(scenario, 6000);
    EXPECT_EQ(doubled.trouble, "");
    EXPECT_EQ(doubled.counters.strobes_rejected, 8U) << "the second of each pair";
    EXPECT_EQ(doubled.counters.samples_lost, 0U);
    scenario.faults.at(0).kind = Fault_kind::strobe_stuck;
    Bench_host host(scenario.instrument, 6000);
    World world(scenario, host, {});
    host.connect(world);
    while (!host.finished() && world.scheduler().run_one(2 * doubled.end_ns)) {
    }
    EXPECT_LT(host.result().counters.strobes, doubled.counters.strobes);
}

// A host that falls silent: the axes stand and the shutter is shut within the expiry, and nothing moves again.
TEST(World, ASilentHostEndsInStandstillAndDarkness) {
    Scenario const scenario = scenario_of("fault_host_silent");
    Bench_host host(scenario.instrument, 6000);
    World world(scenario, host, {});
    host.connect(world);
    while (!world.standstill().watching && world.scheduler().run_one(longest_ns)) {
    }
    ASSERT_TRUE(world.standstill().watching);
    std::int64_t const end_ns = world.scheduler().now_ns() + 8000000000;
    while (world.scheduler().run_one(end_ns)) {
    }
    const Standstill &s = world.standstill();
    ASSERT_TRUE(s.reached);
    EXPECT_GT(s.max_speed_deg_per_s, 1.0) << "it was moving";
    std::int64_t const expiry_ns = 1000000 * static_cast<std::int64_t>(scenario.instrument.cycle.expiry_ms);
    EXPECT_LE(s.standstill_ns - s.since_ns, expiry_ns);
    EXPECT_LE(s.dark_ns - s.since_ns, expiry_ns);
    EXPECT_LT(s.max_speed_after_deg_per_s, 0.05);
    EXPECT_GT(s.dark_ns, s.since_ns);
    EXPECT_TRUE(world.dark());
}

namespace {

struct Recorded {
    std::vector<gn_pose> poses;
    std::map<std::uint64_t, double> sample_time_ns; // by the fitted clock, from settled blocks
    void take(const gn_frame_header &header, const std::uint8_t *payload) {
        if (header.kind == GN_FRAME_POSES) {
            gn_pose_block block{};
            std::memcpy(&block, payload, sizeof block);
            std::size_t const before = poses.size();
            poses.resize(before + block.count);
            std::memcpy(poses.data() + before, payload + sizeof block, block.count * sizeof(gn_pose));
            return;
        }
        gn_sample_block block{};
        std::memcpy(&block, payload, sizeof block);
        for (std::uint32_t i = 0; i < block.count && (block.flags & GN_SAMPLE_BLOCK_CLOCK_UNSETTLED) == 0; ++i) {
            sample_time_ns[block.first_sample + i] = static_cast<double>(block.first_time_ns) + i * block.period_ns;
        }
    }
};

// Lagrange's cubic through the four poses around the time, their delays corrected.
double position_deg(const std::vector<gn_pose> &poses, std::size_t axis, double time_ns, double latch_delay_ns,
                    double per_deg) {
    auto const later = [&](double t, const gn_pose &p) {
        return t < static_cast<double>(p.sync_time_ns) + latch_delay_ns;
    };
    auto const after = std::upper_bound(poses.begin(), poses.end(), time_ns, later);
    auto const first = static_cast<std::size_t>(after - poses.begin()) - 2;
    double sum = 0.0;
    for (std::size_t j = first; j < first + 4; ++j) {
        double weight = 1.0;
        for (std::size_t k = first; k < first + 4; ++k) {
            if (k != j) {
                double const tk = static_cast<double>(poses[k].sync_time_ns) + latch_delay_ns;
                weight *= (time_ns - tk) / static_cast<double>(poses[j].sync_time_ns - poses[k].sync_time_ns);
            }
        }
        sum += weight * poses[j].position_counts[axis];
    }
    return sum / per_deg;
}

} // namespace

// Every sample's place from the fitted clock and the latched positions, against where the axes were.
TEST(World, PairedPositionsAgreeWithTheTruth) {
    Scenario const scenario = scenario_of("pairing");
    std::filesystem::path const truth_path = std::filesystem::path(testing::TempDir()) / "pairing_truth.bin";
    Recorded recorded;
    {
        Bench_host host(scenario.instrument, 12000);
        host.watch_blocks(
            [&](const gn_frame_header &header, const std::uint8_t *payload) { recorded.take(header, payload); });
        World world(scenario, host, truth_path);
        host.connect(world);
        while (!host.finished() && world.scheduler().run_one(longest_ns)) {
        }
        ASSERT_EQ(host.result().trouble, "");
    }
    std::ifstream file(truth_path, std::ios::binary);
    Truth_record truth{};
    double clock_us = 0.0;
    double place_deg = 0.0;
    int compared = 0;
    auto const last_ns = static_cast<double>(recorded.poses.at(recorded.poses.size() - 3).sync_time_ns);
    while (file.read(reinterpret_cast<char *>(&truth), sizeof truth)) {
        auto const found = recorded.sample_time_ns.find(truth.sample);
        if (found == recorded.sample_time_ns.end() || found->second > last_ns) {
            continue;
        }
        clock_us = std::max(clock_us, std::abs(found->second - static_cast<double>(truth.time_ns)) * 1e-3);
        for (std::size_t i = 0; i < axis_count; ++i) {
            double const q_deg =
                position_deg(recorded.poses, i, found->second, 1e3 * scenario.drives.latch_delay_us.at(i),
                             scenario.instrument.axes.at(i).counts_per_deg);
            place_deg = std::max(place_deg, std::abs(q_deg - truth.q_deg.at(i)));
        }
        ++compared;
    }
    EXPECT_GT(compared, 11000);
    RecordProperty("clock_error_us", std::to_string(clock_us));
    RecordProperty("place_error_deg", std::to_string(place_deg));
    std::cout << "largest errors of " << compared << " samples: clock " << clock_us << " us, axis " << place_deg
              << " deg\n";
    EXPECT_LT(clock_us, 20.0);
    EXPECT_LT(place_deg, 0.002);
}

} // namespace gonio::sim
