// test_digitiser_packets.cpp: packet loss, both wraps, and packets that are none.
#include <cstdint>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

extern "C" {
#include "digitiser_packets.h"
}

namespace {

std::vector<std::uint8_t> packet(std::uint16_t number, std::uint32_t first_sample, std::uint16_t count,
                                 std::uint16_t flags = 0) {
    gn_digitiser_packet const header = {0x4744, number, first_sample, count, flags};
    std::vector<std::uint8_t> bytes(sizeof header + std::size_t{count} * GN_SAMPLE_SIZE);
    std::memcpy(bytes.data(), &header, sizeof header);
    return bytes;
}

class Digitiser_packets : public testing::Test {
protected:
    gn_digitiser_packets packets{};
    gn_sample_run run{};

    void SetUp() override { gn_digitiser_packets_start(&packets); }
    bool feed(const std::vector<std::uint8_t> &bytes) {
        return gn_digitiser_packets_parse(&packets, bytes.data(), bytes.size(), &run);
    }
};

TEST_F(Digitiser_packets, a_lost_packet_is_a_counted_gap) {
    ASSERT_TRUE(feed(packet(0, 0, 50)));
    EXPECT_FALSE(run.gap_before);
    ASSERT_TRUE(feed(packet(3, 150, 50)));
    EXPECT_TRUE(run.gap_before);
    EXPECT_EQ(run.first_sample, 150u);
    EXPECT_EQ(packets.packets_lost, 2u);
    EXPECT_EQ(packets.samples_lost, 100u);
    EXPECT_EQ(packets.samples, 100u);
    ASSERT_TRUE(feed(packet(4, 200, 50)));
    EXPECT_FALSE(run.gap_before);
}

TEST_F(Digitiser_packets, packets_lost_right_after_start_count_too) {
    ASSERT_TRUE(feed(packet(2, 100, 50)));
    EXPECT_TRUE(run.gap_before);
    EXPECT_EQ(packets.packets_lost, 2u);
    EXPECT_EQ(packets.samples_lost, 100u);
}

TEST_F(Digitiser_packets, the_packet_counter_wraps_without_a_gap) {
    ASSERT_TRUE(feed(packet(65534, 0, 10))); // a digitiser that does not begin at 0
    for (std::uint32_t i = 1; i < 5; ++i) {
        ASSERT_TRUE(feed(packet(static_cast<std::uint16_t>(65534 + i), 10 * i, 10)));
        EXPECT_FALSE(run.gap_before);
    }
    EXPECT_EQ(packets.packets_lost, 0u);
    ASSERT_TRUE(feed(packet(65533, 50, 10)));
    EXPECT_EQ(packets.packets_lost, 65530u) << "the counter jumped by all but five of its range";
}

TEST_F(Digitiser_packets, the_sample_number_is_unwrapped_to_64_bits) {
    packets.started = true;
    packets.next_sample = (std::uint64_t{5} << 32) - 20;
    ASSERT_TRUE(feed(packet(0, 0xFFFFFFECu, 15)));
    EXPECT_EQ(run.first_sample, (std::uint64_t{5} << 32) - 20);
    ASSERT_TRUE(feed(packet(1, 0xFFFFFFFBu, 15)));
    EXPECT_EQ(run.first_sample, (std::uint64_t{5} << 32) - 5);
    ASSERT_TRUE(feed(packet(3, 25, 15))); // the packet with samples 10 to 24 is lost behind the wrap
    EXPECT_EQ(run.first_sample, (std::uint64_t{5} << 32) + 25);
    EXPECT_EQ(packets.samples_lost, 15u);
}

TEST_F(Digitiser_packets, an_overflow_in_the_digitiser_is_a_gap) {
    ASSERT_TRUE(feed(packet(0, 0, 5)));
    ASSERT_TRUE(feed(packet(1, 5, 5, 1)));
    EXPECT_TRUE(run.gap_before);
}

TEST_F(Digitiser_packets, what_is_no_packet_is_refused_and_missed_by_the_next) {
    ASSERT_TRUE(feed(packet(0, 0, 5)));
    auto bytes = packet(1, 5, 5);
    bytes[0] = 0;
    EXPECT_FALSE(feed(bytes));
    bytes = packet(1, 5, 5);
    bytes.pop_back();
    EXPECT_FALSE(feed(bytes));
    EXPECT_FALSE(feed(packet(1, 5, 256)));
    EXPECT_FALSE(feed(std::vector<std::uint8_t>(11)));
    EXPECT_FALSE(feed(packet(0, 0, 5))) << "samples that came already";
    ASSERT_TRUE(feed(packet(2, 10, 5)));
    EXPECT_EQ(packets.packets_lost, 1u);
    EXPECT_EQ(packets.samples_lost, 5u);
}

} // namespace
