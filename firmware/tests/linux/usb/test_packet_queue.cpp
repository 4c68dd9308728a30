// test_packet_queue.cpp: packets leave in the order of their transfers, none is dropped, and the end is told last.
#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

extern "C" {
#include "packet_queue.h"
}

namespace {

using Bytes = std::vector<std::uint8_t>;

// A device that takes transfers until it is unplugged, and fills them on demand.
class Packet_queue : public testing::Test {
protected:
    std::unique_ptr<gn_packet_queue> queue = std::make_unique<gn_packet_queue>();
    std::vector<std::uint32_t> submitted;
    bool plugged = true;

    void SetUp() override { gn_packet_queue_init(queue.get(), submit, this); }

    void fill(std::uint32_t slot, const Bytes &packet) {
        std::copy(packet.begin(), packet.end(), queue->bytes[slot]);
        gn_packet_queue_complete(queue.get(), slot, static_cast<std::uint32_t>(packet.size()));
    }
    int read(Bytes &packet) {
        packet.resize(4092);
        int const length = gn_packet_queue_read(queue.get(), packet.data(), packet.size());
        packet.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
        return length;
    }

private:
    static bool submit(void *context, std::uint32_t slot) {
        auto &self = *static_cast<Packet_queue *>(context);
        if (self.plugged) {
            self.submitted.push_back(slot);
        }
        return self.plugged;
    }
};

TEST_F(Packet_queue, before_start_there_is_no_device) {
    Bytes packet;
    EXPECT_EQ(read(packet), -1);
    EXPECT_TRUE(submitted.empty());
}

TEST_F(Packet_queue, start_puts_every_slot_into_flight) {
    EXPECT_TRUE(gn_packet_queue_start(queue.get()));
    EXPECT_EQ(submitted.size(), GN_PACKET_SLOTS);
    EXPECT_GE(GN_PACKET_SLOTS, 8u);
    Bytes packet;
    EXPECT_EQ(read(packet), 0);
}

TEST_F(Packet_queue, packets_leave_in_order_and_their_slots_fly_again) {
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    submitted.clear();
    for (std::uint32_t n = 0; n < 5 * GN_PACKET_SLOTS; ++n) {
        fill(n % GN_PACKET_SLOTS, Bytes(12 + n, static_cast<std::uint8_t>(n)));
        Bytes packet;
        ASSERT_EQ(read(packet), static_cast<int>(12 + n));
        ASSERT_EQ(packet, Bytes(12 + n, static_cast<std::uint8_t>(n)));
        ASSERT_EQ(submitted.back(), n % GN_PACKET_SLOTS);
        ASSERT_EQ(queue->in_flight, GN_PACKET_SLOTS);
        ASSERT_EQ(read(packet), 0);
    }
}

TEST_F(Packet_queue, a_later_transfer_waits_for_the_earlier) {
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    fill(1, {2});
    Bytes packet;
    EXPECT_EQ(read(packet), 0);
    fill(0, {1});
    EXPECT_EQ(read(packet), 1);
    EXPECT_EQ(packet, Bytes{1});
    EXPECT_EQ(read(packet), 1);
    EXPECT_EQ(packet, Bytes{2});
}

TEST_F(Packet_queue, an_unread_queue_takes_no_more_from_the_device_and_loses_nothing) {
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    submitted.clear();
    for (std::uint32_t slot = 0; slot < GN_PACKET_SLOTS; ++slot) {
        fill(slot, {static_cast<std::uint8_t>(slot)});
    }
    EXPECT_TRUE(submitted.empty()) << "a full queue asks for no more";
    EXPECT_EQ(queue->in_flight, 0u);
    for (std::uint32_t n = 0; n < GN_PACKET_SLOTS; ++n) {
        Bytes packet;
        ASSERT_EQ(read(packet), 1);
        EXPECT_EQ(packet[0], n);
    }
    Bytes packet;
    EXPECT_EQ(read(packet), 0);
    EXPECT_EQ(submitted.size(), GN_PACKET_SLOTS);
}

TEST_F(Packet_queue, an_empty_transfer_is_no_packet) {
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    fill(0, {});
    fill(1, {7});
    Bytes packet;
    EXPECT_EQ(read(packet), 1);
    EXPECT_EQ(packet, Bytes{7});
}

TEST_F(Packet_queue, a_whole_ring_of_empty_transfers_is_no_packet) {
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    for (std::uint32_t slot = 0; slot < GN_PACKET_SLOTS; ++slot) {
        fill(slot, {});
    }
    Bytes packet;
    EXPECT_EQ(read(packet), 0);
    EXPECT_EQ(queue->in_flight, GN_PACKET_SLOTS);
}

TEST_F(Packet_queue, after_unplugging_all_complete_packets_are_read_before_the_end) {
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    fill(0, {1});
    fill(1, {2});
    plugged = false;
    Bytes packet;
    EXPECT_EQ(read(packet), 1);
    EXPECT_EQ(read(packet), 1);
    EXPECT_EQ(packet, Bytes{2});
    EXPECT_EQ(read(packet), 0) << "transfers that are out may still bring packets";
    fill(2, {3});
    for (std::uint32_t slot = 3; slot < GN_PACKET_SLOTS; ++slot) {
        gn_packet_queue_fail(queue.get(), slot);
    }
    EXPECT_EQ(read(packet), 1);
    EXPECT_EQ(packet, Bytes{3});
    EXPECT_EQ(read(packet), -1);
}

TEST_F(Packet_queue, one_failed_transfer_ends_the_rest) {
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    submitted.clear();
    gn_packet_queue_fail(queue.get(), 0);
    fill(1, {2});
    Bytes packet;
    EXPECT_EQ(read(packet), 1);
    EXPECT_EQ(packet, Bytes{2});
    EXPECT_TRUE(submitted.empty());
}

TEST_F(Packet_queue, a_new_start_drops_what_waited) {
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    fill(0, {1});
    for (std::uint32_t slot = 1; slot < GN_PACKET_SLOTS; ++slot) {
        gn_packet_queue_fail(queue.get(), slot);
    }
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    Bytes packet;
    EXPECT_EQ(read(packet), 0);
    fill(0, {9});
    EXPECT_EQ(read(packet), 1);
    EXPECT_EQ(packet, Bytes{9});
}

TEST_F(Packet_queue, a_start_on_a_device_that_went_fails) {
    plugged = false;
    EXPECT_FALSE(gn_packet_queue_start(queue.get()));
    Bytes packet;
    EXPECT_EQ(read(packet), -1);
}

TEST_F(Packet_queue, an_overlong_packet_is_cut_and_harms_nothing) {
    ASSERT_TRUE(gn_packet_queue_start(queue.get()));
    fill(0, Bytes(GN_PACKET_SLOT_BYTES, 5));
    Bytes packet;
    EXPECT_EQ(read(packet), 4092);
}

} // namespace
