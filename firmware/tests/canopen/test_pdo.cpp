// test_pdo.cpp: PDO packing by our own and by fixed mappings; bytes from the mapping rules of CiA 301.
#include <gtest/gtest.h>

#include "scripted_can.hpp"

extern "C" {
#include "boot_map.h"
#include "pdo.h"
}

namespace gonio::test {
namespace {

TEST(Pdo, packs_controlword_and_target_little_endian) {
    gn_pdo_map rpdo;
    gn_pdo_map tpdo;
    gn_own_maps(&rpdo, &tpdo);
    gn_pdo_command const command{0x001F, -2, 8};
    gn_can_frame frame;
    gn_pdo_pack(&rpdo, 3, &command, &frame);
    EXPECT_EQ(hex(frame), "203#1F00FEFFFFFF");
    EXPECT_EQ(tpdo.length, 6);
}

TEST(Pdo, unpacks_statusword_and_position) {
    gn_pdo_map rpdo;
    gn_pdo_map tpdo;
    gn_own_maps(&rpdo, &tpdo);
    gn_can_frame const frame = frame_of(0x183, {0x37, 0x16, 0x40, 0xE2, 0x01, 0x00});
    std::uint16_t status = 0;
    std::int32_t position = 0;
    ASSERT_TRUE(gn_pdo_unpack(&tpdo, &frame, &status, &position));
    EXPECT_EQ(status, 0x1637);
    EXPECT_EQ(position, 123456);
    gn_can_frame const cut = frame_of(0x183, {0x37, 0x16, 0x40});
    EXPECT_FALSE(gn_pdo_unpack(&tpdo, &cut, &status, &position));
}

TEST(Pdo, follows_a_fixed_map_with_the_mode_in_front) {
    gn_pdo_map map;
    gn_pdo_map_clear(&map);
    ASSERT_TRUE(gn_pdo_map_add(&map, GN_MAP_MODE));
    ASSERT_TRUE(gn_pdo_map_add(&map, GN_MAP_TARGET));
    ASSERT_TRUE(gn_pdo_map_add(&map, GN_MAP_CONTROLWORD));
    gn_pdo_command const command{0x000F, 0x01020304, 8};
    gn_can_frame frame;
    gn_pdo_pack(&map, 1, &command, &frame);
    EXPECT_EQ(hex(frame), "201#08040302010F00");
}

TEST(Pdo, refuses_bits_and_more_than_eight_bytes) {
    gn_pdo_map map;
    gn_pdo_map_clear(&map);
    EXPECT_FALSE(gn_pdo_map_add(&map, 0x60410001));
    EXPECT_FALSE(gn_pdo_map_add(&map, 0x60410000));
    EXPECT_TRUE(gn_pdo_map_add(&map, 0x60640020));
    EXPECT_TRUE(gn_pdo_map_add(&map, 0x606C0020));
    EXPECT_FALSE(gn_pdo_map_add(&map, 0x60410010));
    std::uint16_t status = 0;
    std::int32_t position = 0;
    gn_can_frame const frame = frame_of(0x181, {0, 0, 0, 0, 0, 0, 0, 0});
    EXPECT_FALSE(gn_pdo_unpack(&map, &frame, &status, &position));
}

TEST(Pdo, accepts_a_fixed_map_only_with_what_a_cycle_needs) {
    gn_pdo_map map;
    gn_trouble trouble{};
    gn_pdo_map_clear(&map);
    gn_pdo_map_add(&map, GN_MAP_CONTROLWORD);
    gn_pdo_map_add(&map, 0x60FF0020);
    EXPECT_FALSE(gn_fixed_map_check(&map, 0x1600, &trouble));
    EXPECT_STREQ(trouble.cause, "its fixed PDO map 0x1600 lacks 0x607A (target position)");
    gn_pdo_map_clear(&map);
    gn_pdo_map_add(&map, GN_MAP_STATUSWORD);
    gn_pdo_map_add(&map, GN_MAP_POSITION);
    EXPECT_TRUE(gn_fixed_map_check(&map, 0x1A00, &trouble));
}

} // namespace
} // namespace gonio::test
