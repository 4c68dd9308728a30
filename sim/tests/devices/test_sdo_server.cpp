// test_sdo_server.cpp: SDO dialogues byte by byte, as CiA 301 writes them.
#include <gtest/gtest.h>

#include <numeric>

#include "bench.hpp"
#include "sdo_server.hpp"

namespace gonio::sim {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(Sdo, expedited_uploads_give_the_size) {
    Bench bench(Bench::standard(5));
    EXPECT_EQ(bench.exchange({0x40, 0x00, 0x10, 0, 0, 0, 0, 0}, 5), (Bytes{0x43, 0x00, 0x10, 0, 0x92, 0x01, 0x04, 0}));
    EXPECT_EQ(bench.exchange({0x40, 0x17, 0x10, 0, 0, 0, 0, 0}, 5), (Bytes{0x4B, 0x17, 0x10, 0, 0, 0, 0, 0}));
    EXPECT_EQ(bench.exchange({0x40, 0x18, 0x10, 0, 0, 0, 0, 0}, 5), (Bytes{0x4F, 0x18, 0x10, 0, 4, 0, 0, 0}));
    EXPECT_EQ(bench.exchange({0x40, 0x00, 0x12, 1, 0, 0, 0, 0}, 5), (Bytes{0x43, 0x00, 0x12, 1, 0x05, 0x06, 0, 0}));
}

TEST(Sdo, an_expedited_download_is_confirmed_and_reads_back) {
    Bench bench(Bench::standard());
    EXPECT_EQ(bench.exchange({0x2B, 0x66, 0x60, 0, 0x34, 0x12, 0, 0}), (Bytes{0x60, 0x66, 0x60, 0, 0, 0, 0, 0}));
    EXPECT_EQ(bench.read(0x6066), 0x1234);
    // Without an indicated size the object's own is taken.
    EXPECT_EQ(bench.exchange({0x22, 0x66, 0x60, 0, 0x21, 0x43, 0xEE, 0xEE}), (Bytes{0x60, 0x66, 0x60, 0, 0, 0, 0, 0}));
    EXPECT_EQ(bench.read(0x6066), 0x4321);
}

TEST(Sdo, a_string_is_uploaded_in_segments_with_alternating_toggle) {
    Bench bench(Bench::standard());
    const Bytes first = bench.exchange({0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
    ASSERT_EQ(first[0], 0x41);
    const auto size = static_cast<std::size_t>(value_from_bytes(&first[4], 4, false));
    std::string text;
    std::uint8_t toggle = 0;
    for (bool last = false; !last; toggle ^= 0x10U) {
        const Bytes segment = bench.exchange({static_cast<std::uint8_t>(0x60 | toggle), 0, 0, 0, 0, 0, 0, 0});
        ASSERT_EQ(segment[0] & 0xF0U, toggle);
        const unsigned count = 7U - (segment[0] >> 1U & 7U);
        text.append(segment.begin() + 1, segment.begin() + 1 + count);
        last = (segment[0] & 1U) != 0;
    }
    EXPECT_EQ(text, "gonio twin stepper drive, full");
    EXPECT_EQ(text.size(), size);
    // The transfer is over: one more segment is no valid command.
    EXPECT_EQ(Bench::abort_of(bench.exchange({0x60, 0, 0, 0, 0, 0, 0, 0})), abort_code::unknown_command);
}

TEST(Sdo, a_repeated_toggle_bit_aborts_either_way) {
    Bench bench(Bench::standard());
    bench.exchange({0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
    bench.exchange({0x60, 0, 0, 0, 0, 0, 0, 0});
    const Bytes up = bench.exchange({0x60, 0, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(Bench::abort_of(up), 0x05030000U);
    EXPECT_EQ(up[1], 0x08); // the abort names the object
    EXPECT_EQ(up[2], 0x10);
    bench.exchange({0x21, 0x83, 0x60, 0, 4, 0, 0, 0});
    EXPECT_EQ(Bench::abort_of(bench.exchange({0x17, 1, 2, 3, 4, 0, 0, 0})), 0x05030000U);
}

TEST(Sdo, a_segmented_download_stores_the_value_at_its_end) {
    Bench bench(Bench::standard());
    EXPECT_EQ(bench.exchange({0x21, 0x83, 0x60, 0, 4, 0, 0, 0}), (Bytes{0x60, 0x83, 0x60, 0, 0, 0, 0, 0}));
    EXPECT_EQ(bench.exchange({0x0A, 0x78, 0x56, 0, 0, 0, 0, 0}), (Bytes{0x20, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(bench.exchange({0x1B, 0x34, 0x12, 0, 0, 0, 0, 0}), (Bytes{0x30, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(bench.read(0x6083), 0x12345678);
    // A size that does not fit, announced or found out.
    EXPECT_EQ(Bench::abort_of(bench.exchange({0x21, 0x83, 0x60, 0, 8, 0, 0, 0})), abort_code::wrong_length);
    bench.exchange({0x20, 0x83, 0x60, 0, 0, 0, 0, 0});
    EXPECT_EQ(Bench::abort_of(bench.exchange({0x09, 1, 2, 3, 0, 0, 0, 0})), abort_code::wrong_length);
    EXPECT_EQ(bench.read(0x6083), 0x12345678);
}

TEST(Sdo, refusals_carry_the_standards_codes) {
    Bench bench(Bench::standard());
    EXPECT_EQ(bench.read_abort(0x6079, 0), 0x06020000U);
    EXPECT_EQ(bench.read_abort(0x607D, 7), 0x06090011U);
    EXPECT_EQ(bench.write(0x6079, 0, 1, 4), 0x06020000U);
    EXPECT_EQ(bench.write(0x607D, 7, 1, 4), 0x06090011U);
    EXPECT_EQ(bench.write(0x6041, 0, 1, 2), 0x06010002U);
    EXPECT_EQ(bench.write(0x1008, 0, 1, 4), 0x06010002U);
    EXPECT_EQ(bench.write(0x6065, 0, 1, 2), 0x06070010U);
    EXPECT_EQ(bench.write(0x6040, 0, 1, 4), 0x06070010U);
    EXPECT_EQ(bench.write(0x6007, 0, 4, 2), 0x06090030U);
    EXPECT_EQ(bench.write(0x6060, 0, 3, 1), 0x06090030U);  // profile velocity is not offered
    EXPECT_EQ(bench.write(0x6098, 0, 17, 1), 0x06090030U); // nor homing without index
    EXPECT_EQ(bench.write(0x605A, 0, 3, 2), 0x06090030U);
    EXPECT_EQ(bench.write(0x1005, 0, 0x40000080, 4), 0x06090030U); // no SYNC producer
    EXPECT_EQ(bench.write(0x1019, 0, 1, 1), 0x06090030U);
    EXPECT_EQ(Bench::abort_of(bench.exchange({0xA0, 0x08, 0x10, 0, 127, 0, 0, 0})), 0x05040001U); // block upload
    EXPECT_EQ(bench.drive().counters().sdo_aborts, 15U);
}

TEST(Sdo, a_write_only_object_cannot_be_read) {
    Eds_file eds;
    eds.objects.push_back({0x2000, 0, "key", 7, "wo", false, "5", {}, {}});
    Object_dictionary dictionary(eds, 1);
    struct : Object_guard {
        std::uint32_t before_read(Od_entry &) override { return 0; }
        std::uint32_t before_write(const Od_entry &, std::int64_t) override { return 0; }
        void after_write(Od_entry &) override {}
    } guard;
    Sdo_server server(dictionary, guard);
    const auto answer = server.answer({0x40, 0x00, 0x20, 0, 0, 0, 0, 0}, 0);
    ASSERT_TRUE(answer);
    EXPECT_EQ(Bench::abort_of({answer->begin(), answer->end()}), 0x06010001U);
    EXPECT_EQ((*server.answer({0x23, 0x00, 0x20, 0, 9, 0, 0, 0}, 0))[0], 0x60);
    EXPECT_EQ(dictionary.at(0x2000).value, 9);
}

TEST(Sdo, the_sync_counter_may_change_only_while_sync_has_no_period) {
    Bench bench(Bench::standard());
    EXPECT_EQ(bench.write(0x1019, 0, 10, 1), 0U);
    EXPECT_EQ(bench.write(0x1006, 0, 2000, 4), 0U);
    EXPECT_EQ(bench.write(0x1019, 0, 20, 1), 0x08000022U);
    EXPECT_EQ(bench.read(0x1019), 10);
}

TEST(Sdo, a_client_that_goes_silent_is_told_so_and_an_abort_ends_a_transfer) {
    Bench bench(Bench::standard());
    bench.exchange({0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
    const std::size_t before = bench.recorder.frames.size();
    bench.run_ms(1100);
    ASSERT_EQ(bench.recorder.frames.size(), before + 1);
    const gn_can_frame &frame = bench.recorder.frames.back();
    EXPECT_EQ(value_from_bytes(&frame.data[4], 4, false), 0x05040000);

    bench.exchange({0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
    EXPECT_TRUE(bench.exchange({0x80, 0x08, 0x10, 0, 0, 0, 4, 5}).empty());
    EXPECT_EQ(Bench::abort_of(bench.exchange({0x60, 0, 0, 0, 0, 0, 0, 0})), abort_code::unknown_command);
}

TEST(Sdo, other_nodes_requests_and_short_frames_are_ignored) {
    Bench bench(Bench::standard(2));
    EXPECT_TRUE(bench.exchange({0x40, 0x00, 0x10, 0, 0, 0, 0, 0}, 3).empty());
    EXPECT_TRUE(bench.exchange({0x40, 0x00, 0x10, 0}, 2).empty());
}

} // namespace
} // namespace gonio::sim
