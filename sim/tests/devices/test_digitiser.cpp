// test_digitiser.cpp: packets and strobe as protocol/digitiser.md has them.
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <toml++/toml.h>

#include "digitiser.hpp"

namespace gonio::sim {
namespace {

struct Edge {
    bool rising;
    std::int64_t time_ns;
};

struct Bench {
    explicit Bench(const Digitiser_config &config)
        : digitiser(
              scheduler, config,
              [this](std::uint64_t sample, std::int64_t time_ns) {
                  sample_times_ns.push_back(time_ns);
                  oldest_question_ns = std::max(oldest_question_ns, scheduler.now_ns() - time_ns);
                  gn_sample value{};
                  value.high_counts = static_cast<std::int32_t>(sample);
                  value.temperature_centi_c = -5;
                  return value;
              },
              [this](bool rising) {
                  edges.push_back({rising, scheduler.now_ns()});
              },
              [this] { ++ready; }) {}

    void run_until(std::int64_t time_ns) {
        while (scheduler.run_one(time_ns)) {
        }
    }
    std::vector<std::uint8_t> read() {
        std::vector<std::uint8_t> bytes(5000);
        bytes.resize(static_cast<std::size_t>(digitiser.read(bytes.data(), bytes.size())));
        return bytes;
    }

    Scheduler scheduler;
    std::vector<std::int64_t> sample_times_ns;
    std::vector<Edge> edges;
    std::int64_t oldest_question_ns = 0;
    int ready = 0;
    Digitiser digitiser;
};

constexpr std::int64_t second_ns = 1000000000;

} // namespace

TEST(Digitiser, PacketsHaveTheDocumentedBytes) {
    Bench bench({.first_packet = 65535});
    ASSERT_TRUE(bench.digitiser.start(1000, 10));
    bench.run_until(120000000);
    EXPECT_EQ(bench.ready, 2);
    std::vector<std::uint8_t> const first = bench.read();
    // magic 'DG', packet 65535, first sample 0, count 50, flags 0; sample 0: high 0; sample 1: high 1, temperature -5.
    ASSERT_EQ(first.size(), 12U + 50U * 16U);
    std::vector<std::uint8_t> const header(first.begin(), first.begin() + 12);
    EXPECT_EQ(header, (std::vector<std::uint8_t>{0x44, 0x47, 0xFF, 0xFF, 0, 0, 0, 0, 50, 0, 0, 0}));
    std::vector<std::uint8_t> const sample(first.begin() + 28, first.begin() + 44);
    EXPECT_EQ(sample, (std::vector<std::uint8_t>{1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFB, 0xFF, 0, 0}));
    std::vector<std::uint8_t> const second = bench.read();
    ASSERT_GE(second.size(), 8U);
    EXPECT_EQ(second[2] + 256 * second[3], 0) << "the packet counter wraps";
    EXPECT_EQ(second[4], 50);
    EXPECT_TRUE(bench.read().empty());
}

// protocol/vectors/digitiser.toml, which firmware and host read too.
TEST(Digitiser, FirstPacketEqualsTheGoldenBytes) {
    toml::table const file = toml::parse_file(GONIO_SOURCE_DIR "/protocol/vectors/digitiser.toml");
    toml::table const &vector = *file["vector"][0].as_table();
    toml::array const &samples = *vector["fields"]["samples"].as_array();
    auto const field = [&](std::uint64_t sample, const char *name) {
        return (*samples.get(sample)->as_table())[name].value<std::int64_t>().value();
    };
    Scheduler scheduler;
    Digitiser digitiser(
        scheduler, {.packet_samples = static_cast<std::uint32_t>(samples.size())},
        [&](std::uint64_t sample, std::int64_t) {
            std::uint64_t const k = sample % samples.size();
            return gn_sample{static_cast<std::int32_t>(field(k, "high_counts")),
                             static_cast<std::int32_t>(field(k, "low_counts")),
                             static_cast<std::int32_t>(field(k, "monitor_counts")),
                             static_cast<std::int16_t>(field(k, "temperature_centi_c")),
                             static_cast<std::uint16_t>(field(k, "flags"))};
        },
        [](bool) {}, [] {});
    digitiser.start(1000, 10);
    while (scheduler.run_one(10000000)) {
    }
    std::vector<std::uint8_t> packet(100);
    packet.resize(static_cast<std::size_t>(digitiser.read(packet.data(), packet.size())));
    std::istringstream hex(vector["hex"].value<std::string>().value());
    std::vector<std::uint8_t> golden;
    for (unsigned byte = 0; hex >> std::hex >> byte;) {
        golden.push_back(static_cast<std::uint8_t>(byte));
    }
    ASSERT_EQ(golden.size(), 44U);
    EXPECT_EQ(packet, golden);
}

TEST(Digitiser, StrobeMarksEveryTenthSample) {
    Bench bench({.clock_error_ppm = 100.0});
    bench.digitiser.start(1000, 10);
    bench.run_until(2 * second_ns);
    std::size_t pulse = 0;
    for (std::size_t i = 0; i + 1 < bench.edges.size(); i += 2, ++pulse) {
        ASSERT_TRUE(bench.edges[i].rising);
        ASSERT_FALSE(bench.edges[i + 1].rising);
        if (10 * pulse < bench.sample_times_ns.size()) {
            EXPECT_EQ(bench.edges[i].time_ns, bench.sample_times_ns[10 * pulse]);
        }
        double const width = 1e-6 * static_cast<double>(bench.edges[i + 1].time_ns - bench.edges[i].time_ns);
        EXPECT_NEAR(width, pulse % 64 == 0 ? 5.0 : 2.5, 0.001) << pulse;
    }
    EXPECT_GT(pulse, 190U);
    // Its own crystal: 100 ppm slow.
    double const span = static_cast<double>(bench.sample_times_ns[1900] - bench.sample_times_ns[0]);
    EXPECT_NEAR(span, 1900.0 * 1.0001e6, 1.0);
    EXPECT_LE(bench.oldest_question_ns, 20000000) << "the drives remember 50 ms";
}

TEST(Digitiser, StopIsSilentAndStartBeginsAnew) {
    Bench bench({});
    bench.digitiser.start(1000, 10);
    bench.run_until(61000000);
    bench.digitiser.stop();
    std::size_t const edges = bench.edges.size();
    std::size_t const samples = bench.sample_times_ns.size();
    EXPECT_FALSE(bench.edges.back().rising);
    bench.run_until(second_ns);
    EXPECT_EQ(bench.edges.size(), edges);
    EXPECT_EQ(bench.sample_times_ns.size(), samples);
    EXPECT_TRUE(bench.read().empty());
    bench.digitiser.start(1000, 10);
    bench.run_until(second_ns + 100000000);
    std::vector<std::uint8_t> const packet = bench.read();
    ASSERT_GE(packet.size(), 8U);
    EXPECT_EQ(packet[2] + packet[3] + packet[4] + packet[5], 0) << "packet counter and sample number begin at 0";
    EXPECT_FALSE(bench.digitiser.start(0, 10));
}

TEST(Digitiser, ALostPacketLeavesAJumpOfTheCounter) {
    Bench bench({});
    bench.digitiser.lose_packet();
    bench.digitiser.start(1000, 10);
    bench.run_until(120000000);
    std::vector<std::uint8_t> const packet = bench.read();
    ASSERT_GE(packet.size(), 8U);
    EXPECT_EQ(packet[2], 1);
    EXPECT_EQ(packet[4], 50);
    EXPECT_EQ(bench.digitiser.packets_lost(), 1U);
}

TEST(Digitiser, AFullBufferLosesPacketsAndTheNextOneSaysSo) {
    Bench bench({.most_waiting_packets = 3});
    bench.digitiser.start(1000, 10);
    bench.run_until(310000000); // six packets of 50 ms
    EXPECT_EQ(bench.digitiser.packets_lost(), 3U);
    for (std::uint8_t packet = 0; packet < 3; ++packet) {
        std::vector<std::uint8_t> const bytes = bench.read();
        ASSERT_GE(bytes.size(), 12U);
        EXPECT_EQ(bytes[2], packet);
        EXPECT_EQ(bytes[10], 0) << "nothing was lost before it";
    }
    EXPECT_TRUE(bench.read().empty());
    bench.run_until(410000000);
    EXPECT_EQ(bench.read().at(2), 6) << "the counter counts what was lost";
    bench.digitiser.start(1000, 10);
    bench.run_until(410000000 + 310000000);
    bench.read();
    bench.run_until(410000000 + 360000000);
    bench.read();
    bench.read();
    std::vector<std::uint8_t> const after = bench.read();
    ASSERT_GE(after.size(), 12U);
    EXPECT_EQ(after[10], 1) << "bit 0: the buffer overflowed before this packet";
}

} // namespace gonio::sim
