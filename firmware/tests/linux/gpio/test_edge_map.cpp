// test_edge_map.cpp: line numbers and edge numbers, and what a lost chip means.
#include <gtest/gtest.h>

#include <vector>

extern "C" {
#include "edge_map.h"
}

namespace {

gn_edge_map two_lines() {
    gn_edge_map map{};
    map.has[GN_LINE_STROBE] = true;
    map.offsets[GN_LINE_STROBE] = 4;
    map.has[GN_LINE_DOOR] = true;
    map.offsets[GN_LINE_DOOR] = 17;
    return map;
}

TEST(Edge_map, offsets_become_lines_and_numbers_stay) {
    gn_edge_map map = two_lines();
    gn_edge edge{};
    gn_line_event event = {17, 1, false, 123456789012345u};
    ASSERT_TRUE(gn_edge_map_take(&map, &event, &edge));
    EXPECT_EQ(edge.line, GN_LINE_DOOR);
    EXPECT_EQ(edge.number, 1u);
    EXPECT_FALSE(edge.rising);
    EXPECT_EQ(edge.stamp_ns, 123456789012345);
    event = {4, 90, true, 5u}; // 89 were lost: the core sees it by the number
    ASSERT_TRUE(gn_edge_map_take(&map, &event, &edge));
    EXPECT_EQ(edge.line, GN_LINE_STROBE);
    EXPECT_EQ(edge.number, 90u);
    EXPECT_TRUE(edge.rising);
    event.offset = 5;
    EXPECT_FALSE(gn_edge_map_take(&map, &event, &edge));
}

TEST(Edge_map, interlocks_of_a_lost_chip_fall_once) {
    gn_edge_map map = two_lines();
    map.has[GN_LINE_STO] = true;
    map.offsets[GN_LINE_STO] = 18;
    gn_edge edge{};
    gn_line_event const door = {17, 7, true, 1u};
    gn_line_event const sto = {18, 3, false, 2u}; // is low already
    ASSERT_TRUE(gn_edge_map_take(&map, &door, &edge));
    ASSERT_TRUE(gn_edge_map_take(&map, &sto, &edge));
    ASSERT_TRUE(gn_edge_map_lose(&map, 99, &edge));
    EXPECT_EQ(edge.line, GN_LINE_DOOR);
    EXPECT_EQ(edge.number, 8u); // nothing was lost before it
    EXPECT_FALSE(edge.rising);
    EXPECT_EQ(edge.stamp_ns, 99);
    EXPECT_FALSE(gn_edge_map_lose(&map, 100, &edge)); // the strobe is no interlock
}

} // namespace
