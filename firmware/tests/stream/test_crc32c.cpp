// test_crc32c.cpp: CRC-32C against the examples of RFC 3720 B.4, and the two implementations against each other.
#include <array>
#include <cstdint>
#include <numeric>
#include <random>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

extern "C" {
#include "crc32c.h"
}

namespace {

TEST(Crc32c, rfc_3720_examples) {
    std::array<std::uint8_t, 32> bytes{};
    EXPECT_EQ(gn_crc32c(0, bytes.data(), bytes.size()), 0x8A9136AAu);
    bytes.fill(0xFF);
    EXPECT_EQ(gn_crc32c(0, bytes.data(), bytes.size()), 0x62A8AB43u);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
    EXPECT_EQ(gn_crc32c(0, bytes.data(), bytes.size()), 0x46DD794Eu);
    std::string_view const check = "123456789";
    EXPECT_EQ(gn_crc32c(0, check.data(), check.size()), 0xE3069283u);
    EXPECT_EQ(gn_crc32c_portable(0, check.data(), check.size()), 0xE3069283u);
}

TEST(Crc32c, tables_and_instruction_agree_at_every_length_and_split) {
    std::mt19937 random(1);
    std::vector<std::uint8_t> bytes(300);
    for (auto &byte : bytes) {
        byte = static_cast<std::uint8_t>(random());
    }
    for (std::size_t length = 0; length <= bytes.size(); ++length) {
        std::uint32_t const whole = gn_crc32c(0, bytes.data(), length);
        EXPECT_EQ(gn_crc32c_portable(0, bytes.data(), length), whole) << length;
        std::size_t const split = length / 3;
        std::uint32_t const first = gn_crc32c_portable(0, bytes.data(), split);
        EXPECT_EQ(gn_crc32c(first, bytes.data() + split, length - split), whole) << length;
    }
}

} // namespace
