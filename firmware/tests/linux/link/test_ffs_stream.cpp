// test_ffs_stream.cpp: bytes in order, short transfers, and no byte of one client in the hands of the next.
#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

extern "C" {
#include "ffs_stream.h"
}

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::int64_t cancelled = -104; // -ECONNRESET, as a dequeued USB request ends

// Two bulk endpoints without a bus: transfers wait until the test completes them.
class Ffs_stream : public testing::Test {
protected:
    struct Transfer {
        std::uint32_t slot;
        Bytes bytes;
    };
    std::unique_ptr<gn_ffs_stream> stream = std::make_unique<gn_ffs_stream>();
    std::deque<std::uint32_t> reads; // slots in flight, oldest first
    std::deque<Transfer> writes;
    std::vector<std::pair<gn_ffs_direction, std::uint32_t>> cancels;
    bool enabled = true;

    void SetUp() override {
        gn_ffs_transfers const transfers = {this, submit, cancel};
        gn_ffs_stream_init(stream.get(), &transfers);
    }

    void host_sends(const Bytes &bytes) {
        ASSERT_FALSE(reads.empty());
        std::uint32_t const slot = reads.front();
        reads.pop_front();
        std::copy(bytes.begin(), bytes.end(), stream->slots[GN_FFS_FROM_HOST][slot].bytes);
        gn_ffs_stream_complete(stream.get(), GN_FFS_FROM_HOST, slot, static_cast<std::int64_t>(bytes.size()));
    }
    Bytes host_receives() {
        Transfer const transfer = writes.front();
        writes.pop_front();
        gn_ffs_stream_complete(stream.get(), GN_FFS_TO_HOST, transfer.slot,
                               static_cast<std::int64_t>(transfer.bytes.size()));
        return transfer.bytes;
    }
    // The cancelled transfers come back, in the order of the cancellations.
    void come_back() {
        auto const due = std::exchange(cancels, {});
        for (auto const &[direction, slot] : due) {
            if (direction == GN_FFS_FROM_HOST) {
                reads.erase(std::find(reads.begin(), reads.end(), slot));
            } else {
                writes.erase(std::find_if(writes.begin(), writes.end(),
                                          [slot = slot](const Transfer &each) { return each.slot == slot; }));
            }
            gn_ffs_stream_complete(stream.get(), direction, slot, cancelled);
        }
    }
    int read(Bytes &bytes, std::size_t capacity = 4096) {
        bytes.resize(capacity);
        int const length = gn_ffs_stream_read(stream.get(), bytes.data(), capacity);
        bytes.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
        return length;
    }
    int write(const Bytes &bytes) { return gn_ffs_stream_write(stream.get(), bytes.data(), bytes.size()); }
    static Bytes counted(std::size_t size, std::size_t from = 0) {
        Bytes bytes(size);
        for (std::size_t i = 0; i < size; ++i) {
            bytes[i] = static_cast<std::uint8_t>((from + i) * 7 + (from + i) / 251);
        }
        return bytes;
    }

private:
    static bool submit(void *context, gn_ffs_direction direction, std::uint32_t slot, std::uint8_t *bytes,
                       std::uint32_t length) {
        auto &self = *static_cast<Ffs_stream *>(context);
        if (!self.enabled) {
            return false;
        }
        if (direction == GN_FFS_FROM_HOST) {
            EXPECT_EQ(length, GN_FFS_SLOT_BYTES);
            self.reads.push_back(slot);
        } else {
            self.writes.push_back({slot, Bytes(bytes, bytes + length)});
        }
        return true;
    }
    static void cancel(void *context, gn_ffs_direction direction, std::uint32_t slot) {
        static_cast<Ffs_stream *>(context)->cancels.emplace_back(direction, slot);
    }
};

TEST_F(Ffs_stream, without_a_client_there_is_nothing) {
    Bytes bytes;
    EXPECT_EQ(read(bytes), -1);
    EXPECT_EQ(write({1}), -1);
    EXPECT_TRUE(reads.empty());
}

TEST_F(Ffs_stream, a_client_finds_several_reads_waiting) {
    gn_ffs_stream_begin(stream.get());
    EXPECT_EQ(reads.size(), GN_FFS_SLOTS);
    Bytes bytes;
    EXPECT_EQ(read(bytes), 0);
    EXPECT_FALSE(gn_ffs_stream_idle(stream.get()));
}

TEST_F(Ffs_stream, bytes_from_the_host_come_in_order_in_whatever_pieces) {
    gn_ffs_stream_begin(stream.get());
    Bytes const sent = counted(100000);
    Bytes received;
    std::size_t at = 0;
    for (std::size_t size : {1, 63, 65, 512, 16384, 16384, 16384, 16384, 16384, 10000, 7}) {
        host_sends(Bytes(sent.begin() + static_cast<std::ptrdiff_t>(at),
                         sent.begin() + static_cast<std::ptrdiff_t>(at + size)));
        at += size;
        Bytes bytes;
        while (read(bytes, 4096) > 0) {
            received.insert(received.end(), bytes.begin(), bytes.end());
        }
        ASSERT_EQ(reads.size(), GN_FFS_SLOTS) << "each emptied slot reads again";
    }
    EXPECT_EQ(received, Bytes(sent.begin(), sent.begin() + static_cast<std::ptrdiff_t>(at)));
}

TEST_F(Ffs_stream, an_unread_client_has_to_wait) {
    gn_ffs_stream_begin(stream.get());
    for (std::uint32_t i = 0; i < GN_FFS_SLOTS; ++i) {
        host_sends({static_cast<std::uint8_t>(i)});
    }
    EXPECT_TRUE(reads.empty()) << "the endpoint answers NAK";
    Bytes bytes;
    for (std::uint32_t i = 0; i < GN_FFS_SLOTS; ++i) {
        ASSERT_EQ(read(bytes), 1);
        EXPECT_EQ(bytes[0], i);
    }
    EXPECT_EQ(reads.size(), GN_FFS_SLOTS);
}

TEST_F(Ffs_stream, an_empty_transfer_is_not_the_end) {
    gn_ffs_stream_begin(stream.get());
    host_sends({});
    host_sends({5});
    Bytes bytes;
    EXPECT_EQ(read(bytes), 1);
    EXPECT_EQ(bytes, Bytes{5});
}

TEST_F(Ffs_stream, no_transfer_to_the_host_is_a_multiple_of_64) {
    for (std::size_t size : {1, 63, 64, 65, 128, 512, 1024, 16383, 16384, 16385, 32768}) {
        SCOPED_TRACE(size);
        SetUp();
        writes.clear();
        gn_ffs_stream_begin(stream.get());
        Bytes const sent = counted(size);
        ASSERT_EQ(write(sent), static_cast<int>(size));
        Bytes received;
        while (!writes.empty()) {
            Bytes const transfer = host_receives();
            EXPECT_NE(transfer.size() % 64, 0u) << transfer.size();
            received.insert(received.end(), transfer.begin(), transfer.end());
        }
        EXPECT_EQ(received, sent);
    }
}

TEST_F(Ffs_stream, a_host_that_does_not_read_is_taken_no_more_and_loses_nothing) {
    gn_ffs_stream_begin(stream.get());
    Bytes const sent = counted(400000);
    std::size_t at = 0;
    int taken = 1;
    while (taken > 0) {
        taken = write(Bytes(sent.begin() + static_cast<std::ptrdiff_t>(at), sent.end()));
        ASSERT_GE(taken, 0);
        at += static_cast<std::size_t>(taken);
    }
    EXPECT_EQ(writes.size(), GN_FFS_SLOTS);
    EXPECT_LT(at, sent.size());
    Bytes received;
    while (received.size() < sent.size()) {
        ASSERT_FALSE(writes.empty());
        Bytes const transfer = host_receives();
        received.insert(received.end(), transfer.begin(), transfer.end());
        if (at < sent.size()) {
            at += static_cast<std::size_t>(write(Bytes(sent.begin() + static_cast<std::ptrdiff_t>(at), sent.end())));
        }
    }
    EXPECT_EQ(received, sent);
}

TEST_F(Ffs_stream, open_drops_what_the_client_before_left_and_tells_the_core_once) {
    gn_ffs_stream_begin(stream.get());
    Bytes bytes;
    ASSERT_EQ(read(bytes), 0);
    host_sends({1, 2, 3});
    ASSERT_EQ(write(counted(100)), 100);
    gn_ffs_stream_end(stream.get(), true);
    EXPECT_FALSE(gn_ffs_stream_idle(stream.get()));
    come_back();
    EXPECT_TRUE(gn_ffs_stream_idle(stream.get()));
    EXPECT_TRUE(writes.empty());
    gn_ffs_stream_begin(stream.get());
    host_sends({9});
    EXPECT_EQ(read(bytes), -1) << "the old client is gone";
    EXPECT_EQ(read(bytes), 1);
    EXPECT_EQ(bytes, Bytes{9});
    EXPECT_EQ(read(bytes), 0);
}

TEST_F(Ffs_stream, bytes_that_come_while_open_waits_belong_to_nobody) {
    gn_ffs_stream_begin(stream.get());
    gn_ffs_stream_end(stream.get(), true);
    cancels.erase(std::find(cancels.begin(), cancels.end(), std::pair{GN_FFS_FROM_HOST, reads.front()}));
    host_sends({1, 2, 3}); // it was complete already when it was cancelled
    Bytes bytes;
    EXPECT_EQ(read(bytes), 0);
    come_back();
    gn_ffs_stream_begin(stream.get());
    EXPECT_EQ(read(bytes), -1);
    EXPECT_EQ(read(bytes), 0);
}

TEST_F(Ffs_stream, a_write_may_be_the_first_to_learn_of_the_change) {
    gn_ffs_stream_begin(stream.get());
    gn_ffs_stream_end(stream.get(), true);
    come_back();
    gn_ffs_stream_begin(stream.get());
    EXPECT_EQ(write({1}), -1);
    Bytes bytes;
    EXPECT_EQ(read(bytes), 0);
    EXPECT_EQ(write({1}), 1);
}

TEST_F(Ffs_stream, the_last_words_before_close_are_heard) {
    gn_ffs_stream_begin(stream.get());
    host_sends({1, 2, 3, 4});
    Bytes bytes;
    ASSERT_EQ(read(bytes, 2), 2);
    gn_ffs_stream_end(stream.get(), false);
    EXPECT_EQ(cancels.front().second, (reads.back())) << "newest first, so that no hole arises";
    std::uint32_t const oldest = reads.front();
    cancels.erase(std::find(cancels.begin(), cancels.end(), std::pair{GN_FFS_FROM_HOST, oldest}));
    host_sends({5, 6});
    EXPECT_EQ(read(bytes, 2), 2);
    EXPECT_EQ(write({7}), 1) << "an answer to nobody";
    EXPECT_EQ(read(bytes), 2);
    EXPECT_EQ(bytes, (Bytes{5, 6}));
    EXPECT_EQ(read(bytes), 0) << "more may still come";
    come_back();
    EXPECT_EQ(read(bytes), -1);
    EXPECT_EQ(read(bytes), -1);
    EXPECT_EQ(write({7}), -1);
    EXPECT_TRUE(writes.empty());
}

TEST_F(Ffs_stream, a_failed_transfer_ends_the_client) {
    gn_ffs_stream_begin(stream.get());
    std::uint32_t const slot = reads.front();
    reads.pop_front();
    gn_ffs_stream_complete(stream.get(), GN_FFS_FROM_HOST, slot, -108); // -ESHUTDOWN: the endpoint is off
    EXPECT_EQ(cancels.size(), GN_FFS_SLOTS - 1);
    come_back();
    Bytes bytes;
    EXPECT_EQ(read(bytes), -1);
    EXPECT_TRUE(gn_ffs_stream_idle(stream.get()));
}

TEST_F(Ffs_stream, endpoints_that_take_no_transfer_are_no_client) {
    enabled = false;
    gn_ffs_stream_begin(stream.get());
    EXPECT_FALSE(stream->open);
    EXPECT_TRUE(gn_ffs_stream_idle(stream.get()));
    Bytes bytes;
    EXPECT_EQ(read(bytes), -1);
}

TEST_F(Ffs_stream, a_dismissed_client_still_gets_the_last_words) {
    gn_ffs_stream_begin(stream.get());
    ASSERT_EQ(write({1, 2}), 2);
    gn_ffs_stream_dismiss(stream.get());
    EXPECT_TRUE(
        std::none_of(cancels.begin(), cancels.end(), [](auto const &each) { return each.first == GN_FFS_TO_HOST; }));
    cancels.erase(std::find(cancels.begin(), cancels.end(), std::pair{GN_FFS_FROM_HOST, reads.front()}));
    host_sends({8}); // a byte too late
    come_back();
    EXPECT_EQ(host_receives(), (Bytes{1, 2}));
    Bytes bytes;
    EXPECT_EQ(read(bytes), -1);
    EXPECT_EQ(write({3}), -1);
    gn_ffs_stream_end(stream.get(), true); // OPEN of the next
    gn_ffs_stream_begin(stream.get());
    EXPECT_EQ(read(bytes), 0) << "the core closed the old one itself and need not be told";
}

} // namespace
