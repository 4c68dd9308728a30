// test_personality.cpp: what each personality refuses on the bus, and that a run of four drives repeats bit for bit.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace gonio::sim {
namespace {

TEST(Personality, full_takes_the_whole_set_up) {
    Bench bench(Bench::standard());
    EXPECT_EQ(bench.write(0x6007, 0, 3, 2), 0U);
    EXPECT_EQ(bench.write(0x1029, 1, 0, 1), 0U);
    EXPECT_EQ(bench.write(0x60C2, 1, 4, 1), 0U);
    EXPECT_EQ(bench.write(0x60C2, 2, -3, 1), 0U);
    EXPECT_EQ(bench.read(0x60C2, 2), -3);
    EXPECT_NO_THROW(bench.map_cycle());
}

TEST(Personality, basic_lacks_two_objects_and_keeps_its_period) {
    Bench bench(Bench::standard(1, "basic"));
    EXPECT_EQ(bench.read_abort(0x6007, 0), 0x06020000U);
    EXPECT_EQ(bench.write(0x1029, 1, 0, 1), 0x06020000U);
    EXPECT_EQ(bench.write(0x60C2, 1, 4, 1), 0x06010002U);
    EXPECT_EQ(bench.write(0x60C2, 2, -3, 1), 0x06010002U);
    EXPECT_EQ(bench.read(0x60C2, 1), 2);
    EXPECT_EQ(bench.read(0x60C2, 2), -3);
    EXPECT_NO_THROW(bench.map_cycle());
}

TEST(Personality, fixed_has_its_map_and_no_following_error_window) {
    Bench bench(Bench::standard(1, "fixed"));
    EXPECT_EQ(bench.write(0x1400, 1, 0x80000201, 4), 0U);
    EXPECT_EQ(bench.write(0x1600, 0, 0, 1), 0x06010002U);
    EXPECT_EQ(bench.write(0x1A00, 1, 0x60640020, 4), 0x06010002U);
    EXPECT_EQ(bench.write(0x1400, 1, 0x201, 4), 0U);
    EXPECT_EQ(bench.read(0x1600, 3), 0x60600008);
    EXPECT_EQ(bench.read(0x6065), -1);
}

TEST(Personality, fixed_runs_its_cycle_with_the_mode_in_the_pdo_and_trips_once_the_window_is_set) {
    for (const bool window : {false, true}) {
        Bench bench(Bench::standard(1, "fixed"));
        if (window) {
            bench.write(0x6065, 0, 555, 4);
        }
        bench.nmt(0x01);
        const auto cycle = [&](std::uint8_t controlword, std::int32_t target) {
            std::vector<std::uint8_t> data(7, 0);
            data[0] = controlword;
            value_to_bytes(target, &data[2], 4);
            data[6] = 8;
            bench.send(0x80, {});
            bench.send(0x201, data);
            bench.run_ms(2);
        };
        for (const std::uint8_t controlword : {0x06, 0x06, 0x07, 0x07, 0x0F, 0x0F}) {
            cycle(controlword, 0);
        }
        for (int k = 0; k < 50; ++k) {
            cycle(0x0F, 10 * k);
        }
        const gn_can_frame last = bench.frames_with(0x181).back();
        ASSERT_EQ(last.length, 7);
        EXPECT_EQ(last.data[0] & 0x6F, 0x27);
        EXPECT_EQ(last.data[6], 8);
        EXPECT_NEAR(static_cast<double>(value_from_bytes(&last.data[2], 4, true)), 490.0, 60.0);
        bench.drive().block(true);
        for (int k = 50; k < 250; ++k) {
            cycle(0x0F, 10 * k);
        }
        EXPECT_EQ(bench.emergencies().size(), window ? 1U : 0U);
    }
}

// Abort codes of CiA 301: no such object, no such sub-index.
TEST(Drive_config, objects_that_a_drive_lacks_are_refused_and_it_runs_on_without_them) {
    Drive_config config = Bench::standard();
    config.without = {{0x1400, 5}, {0x6007, {}}, {0x1029, {}}};
    Bench bench(config);
    EXPECT_EQ(bench.read_abort(0x1400, 5), 0x06090011U);
    EXPECT_EQ(bench.write(0x1400, 5, 30, 2), 0x06090011U);
    EXPECT_EQ(bench.write(0x6007, 0, 3, 2), 0x06020000U);
    EXPECT_EQ(bench.read_abort(0x1029, 1), 0x06020000U);
    EXPECT_EQ(bench.write(0x1401, 5, 30, 2), 0U); // the other RPDO has its own
    bench.enable();
    EXPECT_EQ(state_bits(bench.statusword()), 0x27);
    bench.run_ms(500);
    EXPECT_TRUE(bench.emergencies().empty());
}

TEST(Drive_config, a_drive_cannot_be_without_what_it_needs_or_never_had) {
    const auto refusal = [](const Object_name &name) -> std::string {
        Drive_config config = Bench::standard(1, "basic");
        config.without = {name};
        try {
            Bench bench(config);
        } catch (const std::runtime_error &error) {
            return error.what();
        }
        return "";
    };
    for (const Object_name &name : {Object_name{0x6040, {}}, {0x1016, 1}, {0x1400, {}}, {0x1400, 1}, {0x1A00, 3}}) {
        EXPECT_NE(refusal(name).find("cannot be without object 0x"), std::string::npos) << object_text(name);
    }
    EXPECT_NE(refusal({0x6007, {}}).find("no object 0x6007 to take out"), std::string::npos);
    EXPECT_EQ(refusal({0x1800, 5}), "");
}

TEST(Drive_config, turns_and_serial_number_are_in_the_dictionary) {
    Drive_config config = Bench::standard(3, "basic");
    config.counts_per_turn = 65536;
    config.serial = 777;
    Bench bench(config);
    EXPECT_EQ(bench.read(0x608F, 1, 3), 65536);
    EXPECT_EQ(bench.read(0x6092, 1, 3), 65536);
    EXPECT_EQ(bench.read(0x1018, 4, 3), 777);
    config.personality = "odd";
    EXPECT_THROW(Bench{config}, std::runtime_error);
}

std::uint64_t hash_of_a_run() {
    Bench bench;
    const char *const personalities[] = {"full", "basic", "full", "basic"};
    for (std::uint8_t node = 1; node <= 4; ++node) {
        Drive_config config = Bench::standard(node, personalities[node - 1]);
        config.initial_position_counts = 100.25 * node;
        config.latch_delay_us = 10.0 * node;
        bench.add(config);
    }
    bench.run_ms(100);
    for (std::uint8_t node = 1; node <= 4; ++node) {
        bench.write(0x1017, 0, 100, 2, node);
        bench.enable(node);
    }
    for (int k = 0; k < 500; ++k) {
        bench.send(0x80, {});
        for (std::uint8_t node = 1; node <= 4; ++node) {
            bench.set_point(0x0F, 3 * k * node, node);
        }
        bench.run_ms(2);
    }
    std::uint64_t hash = 14695981039346656037ULL; // FNV-1a
    const auto mix = [&hash](std::uint64_t value) { hash = (hash ^ value) * 1099511628211ULL; };
    for (const gn_can_frame &frame : bench.recorder.frames) {
        mix(frame.id);
        mix(static_cast<std::uint64_t>(frame.stamp_ns));
        for (unsigned k = 0; k < frame.length; ++k) {
            mix(frame.data[k]);
        }
    }
    EXPECT_GT(bench.recorder.frames.size(), 4500U);
    return hash;
}

TEST(Drive, the_same_run_gives_the_same_frames_at_the_same_times) {
    EXPECT_EQ(hash_of_a_run(), hash_of_a_run());
}

} // namespace
} // namespace gonio::sim
