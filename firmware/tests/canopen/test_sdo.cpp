// test_sdo.cpp: dialogues of the SDO client, frame by frame (CiA 301): uploads, downloads and every way to abort.
#include <set>

#include <gtest/gtest.h>

#include "scripted_can.hpp"

extern "C" {
#include "sdo.h"
}

namespace gonio::test {
namespace {

constexpr std::int64_t timeout_ns = 200'000'000;

// "> frame" is expected of the client, "< frame" comes from the server.
struct Dialogue {
    Scripted_can can;
    gn_sdo sdo{};
    std::size_t seen = 0;

    Dialogue() { gn_sdo_init(&sdo, 2, timeout_ns); }

    void expect(const std::string &frame) {
        ASSERT_GT(can.sent.size(), seen) << "nothing sent, wanted " << frame;
        EXPECT_EQ(hex(can.sent[seen++]), frame);
    }
    void answer(std::initializer_list<int> bytes, std::int64_t now_ns = 0) {
        gn_can_frame const frame = frame_of(0x582, bytes);
        gn_sdo_on_frame(&sdo, &can.port, &frame, now_ns);
    }
    void expect_silence() const { EXPECT_EQ(can.sent.size(), seen); }
    std::string text() const { return {reinterpret_cast<const char *>(sdo.data), sdo.size}; }
};

TEST(Sdo, expedited_upload_of_each_length) {
    struct {
        int command;
        std::uint32_t size, value;
    } const cases[] = {
        {0x4F, 1, 0x04}, {0x4B, 2, 0x0304}, {0x47, 3, 0x020304}, {0x43, 4, 0x01020304}, {0x42, 4, 0x01020304}};
    for (const auto &c : cases) {
        Dialogue d;
        ASSERT_TRUE(gn_sdo_read(&d.sdo, &d.can.port, 0x1018, 1, 0));
        d.expect("602#4018100100000000");
        d.answer({c.command, 0x18, 0x10, 0x01, 0x04, 0x03, 0x02, 0x01});
        EXPECT_EQ(d.sdo.state, GN_SDO_DONE);
        EXPECT_EQ(d.sdo.size, c.size);
        EXPECT_EQ(gn_sdo_value(&d.sdo), c.value);
        d.expect_silence();
    }
}

TEST(Sdo, segmented_upload_of_a_name) {
    Dialogue d;
    gn_sdo_read(&d.sdo, &d.can.port, 0x1008, 0, 0);
    d.expect("602#4008100000000000");
    d.answer({0x41, 0x08, 0x10, 0x00, 0x10, 0x00, 0x00, 0x00});
    d.expect("602#6000000000000000");
    d.answer({0x00, 'T', 'i', 'n', 'y', ' ', 'N', 'o'});
    d.expect("602#7000000000000000");
    d.answer({0x10, 'd', 'e', ' ', '-', ' ', 'M', 'e'});
    d.expect("602#6000000000000000");
    d.answer({0x0B, 'g', 'a', 0, 0, 0, 0, 0}); // two bytes, last
    EXPECT_EQ(d.sdo.state, GN_SDO_DONE);
    EXPECT_EQ(d.text(), "Tiny Node - Mega");
    d.expect_silence();
}

TEST(Sdo, segmented_upload_without_announced_size) {
    Dialogue d;
    gn_sdo_read(&d.sdo, &d.can.port, 0x1009, 0, 0);
    d.answer({0x40, 0x09, 0x10, 0x00, 0, 0, 0, 0});
    d.answer({0x09, 'A', 'B', 'C', 0, 0, 0, 0});
    EXPECT_EQ(d.sdo.state, GN_SDO_DONE);
    EXPECT_EQ(d.text(), "ABC");
}

TEST(Sdo, expedited_download_of_each_length) {
    struct {
        std::uint32_t size;
        const char *frame;
    } const cases[] = {{1, "602#2F0710FF44000000"}, {2, "602#2B0710FF44330000"}, {4, "602#230710FF44332211"}};
    for (const auto &c : cases) {
        Dialogue d;
        ASSERT_TRUE(gn_sdo_write(&d.sdo, &d.can.port, 0x1007, 0xFF, 0x11223344, c.size, 0));
        d.expect(c.frame);
        EXPECT_EQ(d.sdo.state, GN_SDO_BUSY);
        d.answer({0x60, 0x07, 0x10, 0xFF, 0, 0, 0, 0});
        EXPECT_EQ(d.sdo.state, GN_SDO_DONE);
        d.expect_silence();
    }
}

TEST(Sdo, server_aborts_an_upload_and_a_download) {
    for (bool const upload : {true, false}) {
        Dialogue d;
        if (upload) {
            gn_sdo_read(&d.sdo, &d.can.port, 0x6007, 0, 0);
        } else {
            gn_sdo_write(&d.sdo, &d.can.port, 0x6007, 0, 3, 2, 0);
        }
        d.seen = 1;
        d.answer({0x80, 0x07, 0x60, 0x00, 0x00, 0x00, 0x02, 0x06});
        EXPECT_EQ(d.sdo.state, GN_SDO_ABORTED);
        EXPECT_EQ(d.sdo.abort_code, 0x06020000u);
        d.expect_silence();
    }
}

TEST(Sdo, server_aborts_between_segments) {
    Dialogue d;
    gn_sdo_read(&d.sdo, &d.can.port, 0x1008, 0, 0);
    d.answer({0x41, 0x08, 0x10, 0x00, 0x10, 0, 0, 0});
    d.answer({0x80, 0x08, 0x10, 0x00, 0x21, 0x00, 0x00, 0x08});
    EXPECT_EQ(d.sdo.state, GN_SDO_ABORTED);
    EXPECT_EQ(d.sdo.abort_code, 0x08000021u);
}

TEST(Sdo, client_aborts_when_the_toggle_bit_stays) {
    Dialogue d;
    gn_sdo_read(&d.sdo, &d.can.port, 0x1008, 0, 0);
    d.answer({0x41, 0x08, 0x10, 0x00, 0x10, 0, 0, 0});
    d.answer({0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'});
    d.seen = 3;
    d.answer({0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'});
    d.expect("602#8008100000000305");
    EXPECT_EQ(d.sdo.state, GN_SDO_ABORTED);
    EXPECT_EQ(d.sdo.abort_code, 0x05030000u);
}

TEST(Sdo, client_aborts_when_the_length_is_not_the_announced_one) {
    Dialogue d;
    gn_sdo_read(&d.sdo, &d.can.port, 0x1008, 0, 0);
    d.answer({0x41, 0x08, 0x10, 0x00, 0x10, 0, 0, 0});
    d.seen = 2;
    d.answer({0x01, 'a', 'b', 'c', 'd', 'e', 'f', 'g'});
    d.expect("602#8008100010000706");
    EXPECT_EQ(d.sdo.abort_code, 0x06070010u);
}

TEST(Sdo, client_aborts_what_does_not_fit_announced_or_not) {
    Dialogue announced;
    gn_sdo_read(&announced.sdo, &announced.can.port, 0x1008, 0, 0);
    announced.answer({0x41, 0x08, 0x10, 0x00, GN_SDO_CAPACITY + 1, 0, 0, 0});
    announced.seen = 1;
    announced.expect("602#8008100005000405");
    EXPECT_EQ(announced.sdo.abort_code, 0x05040005u);

    Dialogue endless;
    gn_sdo_read(&endless.sdo, &endless.can.port, 0x1008, 0, 0);
    endless.answer({0x40, 0x08, 0x10, 0x00, 0, 0, 0, 0});
    for (int i = 0; i < 20 && endless.sdo.state == GN_SDO_BUSY; i++) {
        endless.answer({i % 2 ? 0x10 : 0x00, 1, 2, 3, 4, 5, 6, 7});
    }
    EXPECT_EQ(endless.sdo.state, GN_SDO_ABORTED);
    EXPECT_EQ(endless.sdo.abort_code, 0x05040005u);
    EXPECT_LE(endless.sdo.size, GN_SDO_CAPACITY);
}

TEST(Sdo, client_aborts_an_answer_of_the_wrong_kind) {
    Dialogue d;
    gn_sdo_write(&d.sdo, &d.can.port, 0x1017, 0, 100, 2, 0);
    d.seen = 1;
    d.answer({0x4B, 0x17, 0x10, 0x00, 100, 0, 0, 0});
    d.expect("602#8017100001000405");
    EXPECT_EQ(d.sdo.abort_code, 0x05040001u);
}

TEST(Sdo, times_out_says_so_to_the_server_and_ignores_its_late_answer) {
    Dialogue d;
    gn_sdo_read(&d.sdo, &d.can.port, 0x1000, 0, 5);
    gn_sdo_process(&d.sdo, &d.can.port, 5 + timeout_ns - 1);
    EXPECT_EQ(d.sdo.state, GN_SDO_BUSY);
    gn_sdo_process(&d.sdo, &d.can.port, 5 + timeout_ns);
    EXPECT_EQ(d.sdo.state, GN_SDO_TIMED_OUT);
    d.seen = 1;
    d.expect("602#8000100000000405");
    gn_sdo_reset(&d.sdo);
    gn_sdo_read(&d.sdo, &d.can.port, 0x1018, 1, 6 + timeout_ns);
    d.answer({0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0, 0});
    EXPECT_EQ(d.sdo.state, GN_SDO_BUSY);
    d.answer({0x43, 0x18, 0x10, 0x01, 7, 0, 0, 0});
    EXPECT_EQ(gn_sdo_value(&d.sdo), 7u);
}

TEST(Sdo, each_segment_restarts_the_time_out) {
    Dialogue d;
    gn_sdo_read(&d.sdo, &d.can.port, 0x1008, 0, 0);
    d.answer({0x41, 0x08, 0x10, 0x00, 0x08, 0, 0, 0}, timeout_ns - 1);
    gn_sdo_process(&d.sdo, &d.can.port, timeout_ns + 1);
    EXPECT_EQ(d.sdo.state, GN_SDO_BUSY);
    gn_sdo_process(&d.sdo, &d.can.port, 2 * timeout_ns);
    EXPECT_EQ(d.sdo.state, GN_SDO_TIMED_OUT);
}

TEST(Sdo, takes_one_transfer_at_a_time_and_no_short_frames) {
    Dialogue d;
    gn_sdo_read(&d.sdo, &d.can.port, 0x1000, 0, 0);
    EXPECT_FALSE(gn_sdo_read(&d.sdo, &d.can.port, 0x1001, 0, 0));
    EXPECT_FALSE(gn_sdo_write(&d.sdo, &d.can.port, 0x1001, 0, 1, 1, 0));
    d.answer({0x43, 0x00, 0x10, 0x00});
    EXPECT_EQ(d.sdo.state, GN_SDO_BUSY);
}

// CiA 301, table 22: all of it.
constexpr std::uint32_t abort_codes[] = {
    0x05030000, 0x05040000, 0x05040001, 0x05040002, 0x05040003, 0x05040004, 0x05040005, 0x06010000,
    0x06010001, 0x06010002, 0x06020000, 0x06040041, 0x06040042, 0x06040043, 0x06040047, 0x06060000,
    0x06070010, 0x06070012, 0x06070013, 0x06090011, 0x06090030, 0x06090031, 0x06090032, 0x06090036,
    0x060A0023, 0x08000000, 0x08000020, 0x08000021, 0x08000022, 0x08000023, 0x08000024};

TEST(Sdo, every_abort_of_the_standard_ends_every_sort_of_transfer_with_its_words) {
    std::set<std::string> words;
    for (std::uint32_t const code : abort_codes) {
        for (int const sort : {0, 1, 2}) { // download, upload, between segments
            Dialogue d;
            if (sort == 0) {
                gn_sdo_write(&d.sdo, &d.can.port, 0x1008, 0, 1, 4, 0);
            } else {
                gn_sdo_read(&d.sdo, &d.can.port, 0x1008, 0, 0);
            }
            if (sort == 2) {
                d.answer({0x41, 0x08, 0x10, 0x00, 0x10, 0, 0, 0});
            }
            d.seen = d.can.sent.size();
            d.answer({0x80, 0x08, 0x10, 0x00, static_cast<int>(code & 0xFF), static_cast<int>(code >> 8 & 0xFF),
                      static_cast<int>(code >> 16 & 0xFF), static_cast<int>(code >> 24)});
            EXPECT_EQ(d.sdo.state, GN_SDO_ABORTED);
            EXPECT_EQ(d.sdo.abort_code, code);
            d.expect_silence();
        }
        words.insert(gn_sdo_abort_words(code));
    }
    EXPECT_EQ(words.size(), std::size(abort_codes));
    EXPECT_EQ(words.count(gn_sdo_abort_words(0x12345678)), 0u);
}

TEST(Sdo, puts_abort_codes_into_words) {
    EXPECT_STREQ(gn_sdo_abort_words(0x06010002), "object is read only");
    EXPECT_STREQ(gn_sdo_abort_words(0x06090011), "subindex does not exist");
    EXPECT_STREQ(gn_sdo_abort_words(0x08000022), "data cannot be stored in this device state");
    EXPECT_STREQ(gn_sdo_abort_words(0x12345678), "abort code unknown to the standard");
}

} // namespace
} // namespace gonio::test
