// test_pdo.cpp: mapping in the order that CiA 301 demands, transmission types, inhibit time, event timer, deadline.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace gonio::sim {
namespace {

constexpr std::uint32_t device_state = 0x08000022;

TEST(Pdo_mapping, may_change_only_while_the_pdo_does_not_exist_and_has_no_entries) {
    Bench bench(Bench::standard());
    EXPECT_EQ(bench.write(0x1600, 0, 0, 1), device_state); // the PDO exists
    EXPECT_EQ(bench.write(0x1600, 2, 0x607A0020, 4), device_state);
    EXPECT_EQ(bench.write(0x1400, 1, 0x80000201, 4), 0U);
    EXPECT_EQ(bench.write(0x1600, 2, 0x607A0020, 4), device_state); // it still has entries
    EXPECT_EQ(bench.write(0x1600, 0, 0, 1), 0U);
    EXPECT_EQ(bench.write(0x1600, 2, 0x607A0020, 4), 0U);
    EXPECT_EQ(bench.write(0x1600, 0, 2, 1), 0U);
    EXPECT_EQ(bench.write(0x1600, 1, 0x60400010, 4), device_state);
    EXPECT_EQ(bench.write(0x1400, 1, 0x201, 4), 0U);
    EXPECT_EQ(bench.write(0x1600, 0, 0, 1), device_state);
}

TEST(Pdo_mapping, refuses_what_cannot_be_mapped) {
    Bench bench(Bench::standard());
    bench.write(0x1800, 1, 0xC0000181, 4);
    bench.write(0x1A00, 0, 0, 1);
    EXPECT_EQ(bench.write(0x1A00, 1, 0x60790010, 4), 0x06020000U); // no such object
    EXPECT_EQ(bench.write(0x1A00, 1, 0x60FE0520, 4), 0x06090011U); // no such sub-index
    EXPECT_EQ(bench.write(0x1A00, 1, 0x60650020, 4), 0x06040041U); // not mappable
    EXPECT_EQ(bench.write(0x1A00, 1, 0x60640010, 4), 0x06040041U); // not its length
    EXPECT_EQ(bench.write(0x1A00, 1, 0x00050008, 4), 0x06040041U); // a gap, but in a TPDO
    EXPECT_EQ(bench.write(0x1A00, 1, 0x60640020, 4), 0U);
    EXPECT_EQ(bench.write(0x1A00, 2, 0x606C0020, 4), 0U);
    EXPECT_EQ(bench.write(0x1A00, 3, 0x60410010, 4), 0U);
    EXPECT_EQ(bench.write(0x1A00, 0, 3, 1), 0x06040042U); // 10 bytes
    EXPECT_EQ(bench.write(0x1A00, 0, 4, 1), 0x06020000U); // the fourth entry holds nothing
    EXPECT_EQ(bench.write(0x1A00, 0, 9, 1), 0x06090030U);
    EXPECT_EQ(bench.write(0x1A00, 0, 2, 1), 0U);
    bench.write(0x1400, 1, 0x80000201, 4);
    bench.write(0x1600, 0, 0, 1);
    EXPECT_EQ(bench.write(0x1600, 1, 0x60640020, 4), 0x06040041U); // read-only in an RPDO
}

TEST(Pdo_communication, identifiers_and_types_follow_the_standard) {
    Bench bench(Bench::standard());
    EXPECT_EQ(bench.write(0x1400, 1, 0x202, 4), device_state);     // the identifier of a PDO that exists
    EXPECT_EQ(bench.write(0x1400, 1, 0x80000202, 4), 0U);          // switched off, it may change
    EXPECT_EQ(bench.write(0x1400, 1, 0x00000601, 4), 0x06090030U); // an SDO's identifier
    EXPECT_EQ(bench.write(0x1400, 1, 0x20000202, 4), 0x06090030U); // 29 bits
    EXPECT_EQ(bench.write(0x1400, 1, 0x202, 4), 0U);
    EXPECT_EQ(bench.write(0x1800, 2, 241, 1), 0x06090030U);
    EXPECT_EQ(bench.write(0x1800, 2, 253, 1), 0x06090030U); // on remote request only
    EXPECT_EQ(bench.write(0x1800, 2, 254, 1), 0U);
    EXPECT_EQ(bench.write(0x1800, 3, 100, 2), device_state); // inhibit time of a PDO that exists
    EXPECT_EQ(bench.write(0x1800, 4, 0, 1), 0x06090011U);    // sub-index 4 is reserved
}

TEST(Pdo, a_gap_in_an_rpdo_is_skipped) {
    Bench bench(Bench::standard());
    bench.write(0x1401, 1, 0x80000301, 4);
    bench.write(0x1601, 0, 0, 1);
    EXPECT_EQ(bench.write(0x1601, 1, 0x00060010, 4), 0U); // UNSIGNED16 of nobody
    EXPECT_EQ(bench.write(0x1601, 2, 0x60600008, 4), 0U);
    EXPECT_EQ(bench.write(0x1601, 0, 2, 1), 0U);
    EXPECT_EQ(bench.write(0x1401, 1, 0x301, 4), 0U);
    bench.nmt(0x01);
    bench.send(0x301, {0xAA, 0xBB, 0x06});
    bench.run_ms(3);
    EXPECT_EQ(bench.read(0x6060), 6);
}

TEST(Pdo, a_synchronous_rpdo_takes_effect_at_the_next_sync) {
    Bench bench(Bench::standard());
    bench.map_cycle();
    bench.nmt(0x01);
    bench.set_point(0x06, 0);
    bench.run_ms(5);
    EXPECT_EQ(state_bits(bench.statusword()), 0x40);
    bench.send(0x80, {});
    bench.run_ms(1);
    EXPECT_EQ(state_bits(bench.statusword()), 0x21);
}

TEST(Pdo, nothing_is_sent_or_taken_outside_operational) {
    Bench bench(Bench::standard());
    bench.map_cycle();
    for (int k = 0; k < 3; ++k) {
        bench.cycle(0x06, 0);
    }
    EXPECT_TRUE(bench.frames_with(0x181).empty());
    EXPECT_EQ(state_bits(bench.statusword()), 0x40);
}

TEST(Pdo, a_tpdo_of_type_n_comes_with_every_nth_sync) {
    Bench bench(Bench::standard());
    bench.map_cycle();
    bench.write(0x1800, 2, 3, 1);
    bench.nmt(0x01);
    for (int k = 0; k < 12; ++k) {
        bench.send(0x80, {});
        bench.run_ms(2);
    }
    EXPECT_EQ(bench.frames_with(0x181).size(), 4U);
}

TEST(Pdo, a_sync_start_value_says_where_counting_begins) {
    Bench bench(Bench::standard());
    bench.map_cycle();
    bench.write(0x1019, 0, 8, 1);
    bench.write(0x1800, 1, 0xC0000181, 4);
    bench.write(0x1800, 2, 4, 1);
    EXPECT_EQ(bench.write(0x1800, 6, 3, 1), 0U);
    bench.write(0x1800, 1, 0x40000181, 4);
    bench.nmt(0x01);
    std::vector<int> counts;
    for (int k = 0; k < 16; ++k) {
        const std::size_t before = bench.frames_with(0x181).size();
        bench.send(0x80, {static_cast<std::uint8_t>(k % 8 + 1)});
        bench.run_ms(2);
        if (bench.frames_with(0x181).size() > before) {
            counts.push_back(k % 8 + 1);
        }
    }
    EXPECT_EQ(counts, (std::vector<int>{3, 7, 3, 7}));
}

TEST(Pdo, an_event_driven_tpdo_comes_on_change_not_faster_than_its_inhibit_time) {
    Bench bench(Bench::standard());
    bench.write(0x1801, 1, 0xC0000281, 4);
    bench.write(0x1A01, 0, 0, 1);
    bench.write(0x1A01, 1, 0x60FD0020, 4);
    bench.write(0x1A01, 2, 0x603F0010, 4);
    bench.write(0x1A01, 0, 2, 1);
    bench.write(0x1801, 2, 254, 1);
    EXPECT_EQ(bench.write(0x1801, 3, 500, 2), 0U); // 50 ms
    bench.write(0x1801, 1, 0x40000281, 4);
    bench.nmt(0x01);
    bench.run_ms(200);
    ASSERT_EQ(bench.frames_with(0x281).size(), 1U); // the first values
    for (int k = 0; k < 10; ++k) {                  // STO toggles bit 3 of 0x60FD every 10 ms
        bench.drive().set_sto(k % 2 != 0);
        bench.run_ms(10);
    }
    bench.run_ms(100);
    const auto frames = bench.frames_with(0x281);
    ASSERT_GE(frames.size(), 3U);
    EXPECT_EQ(frames[1].data[0] & 8U, 8U);
    for (std::size_t k = 1; k < frames.size(); ++k) {
        EXPECT_GE(frames[k].stamp_ns - frames[k - 1].stamp_ns, 49 * ns_per_ms);
    }
    EXPECT_EQ(frames.back().data[0] & 8U, 0U); // the last state arrives
}

TEST(Pdo, an_event_timer_repeats_a_tpdo) {
    Bench bench(Bench::standard());
    bench.write(0x1800, 5, 20, 2);
    bench.nmt(0x01);
    bench.run_ms(200);
    EXPECT_NEAR(static_cast<double>(bench.frames_with(0x181).size()), 10.0, 1.0);
}

TEST(Pdo, wrong_lengths_are_reported_and_short_ones_not_taken) {
    Bench bench(Bench::standard());
    bench.map_cycle();
    bench.nmt(0x01);
    bench.send(0x201, {0x06, 0x00, 0x00});
    bench.send(0x80, {});
    bench.run_ms(3);
    EXPECT_EQ(bench.emergencies(), (std::vector<std::uint16_t>{0x8210}));
    EXPECT_EQ(state_bits(bench.statusword()), 0x40);
    bench.set_point(0x00, 0);
    bench.send(0x201, {0x06, 0, 0, 0, 0, 0, 0, 0});
    bench.send(0x80, {});
    bench.run_ms(3);
    EXPECT_EQ(bench.emergencies().back(), 0x8220);
    bench.cycle(0x06, 0);
    bench.send(0x80, {});
    bench.run_ms(1);
    EXPECT_EQ(state_bits(bench.statusword()), 0x21);
}

TEST(Pdo, a_sync_of_the_wrong_length_is_reported_once) {
    Bench bench(Bench::standard());
    bench.map_cycle();
    bench.nmt(0x01);
    for (int k = 1; k < 4; ++k) {
        bench.send(0x80, {static_cast<std::uint8_t>(k)});
        bench.run_ms(2);
    }
    EXPECT_EQ(bench.emergencies(), (std::vector<std::uint16_t>{0x8240}));
}

TEST(Pdo, a_synchronous_tpdo_after_the_window_is_not_sent) {
    Drive_config config = Bench::standard();
    config.latch_delay_us = 300.0;
    Bench bench(config);
    bench.map_cycle();
    bench.nmt(0x01);
    bench.write(0x1007, 0, 200, 4);
    bench.send(0x80, {});
    bench.run_ms(2);
    EXPECT_TRUE(bench.frames_with(0x181).empty());
    bench.write(0x1007, 0, 1500, 4);
    bench.send(0x80, {});
    bench.run_ms(2);
    EXPECT_EQ(bench.frames_with(0x181).size(), 1U);
}

TEST(Pdo_deadline, a_missing_rpdo_is_an_emergency_and_aborts_the_connection) {
    Bench bench(Bench::standard());
    bench.write(0x1400, 5, 6, 2);
    bench.write(0x6007, 0, 3, 2); // quick stop
    bench.write(0x605A, 0, 6, 2); // and stay there
    bench.enable();
    ASSERT_EQ(bench.drive().statusword() & 0x6FU, 0x27U);
    bench.run_ms(20);
    ASSERT_EQ(bench.drive().statusword() & 0x6FU, 0x07U);
    EXPECT_EQ(bench.emergencies(), (std::vector<std::uint16_t>{0x8250}));
    EXPECT_EQ(bench.read(0x1001), 0x11);
    EXPECT_EQ(bench.read(0x1003, 1) & 0xFFFF, 0x8250);

    bench.cycle(0x0F, 0); // the connection is back: the error is taken back, and 16 leads out of quick stop
    bench.cycle(0x0F, 0);
    bench.send(0x80, {});
    EXPECT_EQ(bench.emergencies().back(), 0x0000);
    bench.run_ms(2);
    EXPECT_EQ(bench.drive().statusword() & 0x6FU, 0x27U);
}

TEST(Pdo_deadline, without_traffic_before_there_is_no_deadline_and_outside_operational_neither) {
    Bench bench(Bench::standard());
    bench.map_cycle();
    bench.write(0x1400, 5, 6, 2);
    bench.nmt(0x01);
    bench.run_ms(100);
    EXPECT_TRUE(bench.emergencies().empty());
    bench.cycle(0x06, 0);
    bench.nmt(0x80);
    bench.run_ms(100);
    EXPECT_TRUE(bench.emergencies().empty());
}

} // namespace
} // namespace gonio::sim
