// test_ffs_descriptors.cpp: the bytes that FunctionFS gets, against USB 2.0 (9.6), USB 3.2 (9.6.7), Microsoft's OS
// descriptors 1.0 and linux/usb/functionfs.h.
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

extern "C" {
#include "ffs_descriptors.h"
}

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes descriptors() {
    Bytes bytes(GN_FFS_DESCRIPTORS_MAX);
    bytes.resize(gn_ffs_descriptors(bytes.data()));
    return bytes;
}

std::uint32_t u32(const Bytes &bytes, std::size_t at) {
    return bytes.at(at) | bytes.at(at + 1) << 8u | bytes.at(at + 2) << 16u |
           static_cast<std::uint32_t>(bytes.at(at + 3)) << 24u;
}

Bytes part(const Bytes &bytes, std::size_t at, std::size_t size) {
    return {bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.begin() + static_cast<std::ptrdiff_t>(at + size)};
}

const Bytes interface_descriptor = {9, 4, 0, 0, 2, 0xFF, 0x47, 0x4C, 1};
const std::size_t speeds_at = 12 + 4 * 4;
const std::size_t speed_size = 9 + 7 + 7;
const std::size_t super_speed_size = 9 + 2 * (7 + 6);
const std::size_t os_at = speeds_at + 2 * speed_size + super_speed_size;

TEST(Ffs_descriptors, the_head_counts_what_follows) {
    Bytes const bytes = descriptors();
    EXPECT_EQ(u32(bytes, 0), 3u);             // second version of the head
    EXPECT_EQ(u32(bytes, 4), bytes.size());   // its own length included
    EXPECT_EQ(u32(bytes, 8), 1u + 2 + 4 + 8); // full, high, super speed, Microsoft OS
    EXPECT_EQ(u32(bytes, 12), 3u);
    EXPECT_EQ(u32(bytes, 16), 3u);
    EXPECT_EQ(u32(bytes, 20), 5u);
    EXPECT_EQ(u32(bytes, 24), 2u);
}

TEST(Ffs_descriptors, full_and_high_speed_have_their_packet_sizes) {
    Bytes const bytes = descriptors();
    EXPECT_EQ(part(bytes, speeds_at, 9), interface_descriptor);
    EXPECT_EQ(part(bytes, speeds_at + 9, 7), (Bytes{7, 5, 0x81, 2, 64, 0, 0}));
    EXPECT_EQ(part(bytes, speeds_at + 16, 7), (Bytes{7, 5, 0x02, 2, 64, 0, 0}));
    std::size_t const high = speeds_at + speed_size;
    EXPECT_EQ(part(bytes, high, 9), interface_descriptor);
    EXPECT_EQ(part(bytes, high + 9, 7), (Bytes{7, 5, 0x81, 2, 0, 2, 0}));
    EXPECT_EQ(part(bytes, high + 16, 7), (Bytes{7, 5, 0x02, 2, 0, 2, 0}));
}

TEST(Ffs_descriptors, super_speed_endpoints_have_companions) {
    Bytes const bytes = descriptors();
    std::size_t const super = speeds_at + 2 * speed_size;
    EXPECT_EQ(part(bytes, super, 9), interface_descriptor);
    EXPECT_EQ(part(bytes, super + 9, 13), (Bytes{7, 5, 0x81, 2, 0, 4, 0, 6, 48, 0, 0, 0, 0}));
    EXPECT_EQ(part(bytes, super + 22, 13), (Bytes{7, 5, 0x02, 2, 0, 4, 0, 6, 48, 0, 0, 0, 0}));
}

TEST(Ffs_descriptors, windows_is_told_to_load_winusb) {
    Bytes const bytes = descriptors();
    EXPECT_EQ(part(bytes, os_at, 11), (Bytes{0, 35, 0, 0, 0, 1, 0, 4, 0, 1, 0}));
    Bytes entry = {0, 1, 'W', 'I', 'N', 'U', 'S', 'B'};
    entry.resize(24);
    EXPECT_EQ(part(bytes, os_at + 11, 24), entry);
}

TEST(Ffs_descriptors, programs_find_the_interface_by_its_guid) {
    Bytes const bytes = descriptors();
    std::size_t const header = os_at + 35;
    std::size_t const entry = header + 11;
    std::uint32_t const size = u32(bytes, entry);
    EXPECT_EQ(u32(bytes, header + 1), 11 + size);
    EXPECT_EQ(bytes[header + 7], 5);
    EXPECT_EQ(entry + size, bytes.size());
    EXPECT_EQ(u32(bytes, entry + 4), 1u); // REG_SZ
    std::string_view const name("DeviceInterfaceGUID", 20);
    EXPECT_EQ(bytes[entry + 8], name.size());
    EXPECT_EQ(bytes[entry + 9], 0);
    EXPECT_EQ(std::memcmp(bytes.data() + entry + 10, name.data(), name.size()), 0);
    std::size_t const value = entry + 10 + name.size();
    ASSERT_EQ(u32(bytes, value), 39u); // {8-4-4-4-12} and a 0
    EXPECT_EQ(size, 14 + name.size() + 39);
    EXPECT_EQ(bytes[value + 4], '{');
    EXPECT_EQ(bytes[value + 4 + 37], '}');
    EXPECT_EQ(bytes[value + 4 + 38], 0);
    for (std::size_t dash : {9, 14, 19, 24}) {
        EXPECT_EQ(bytes[value + 4 + dash], '-');
    }
}

TEST(Ffs_descriptors, one_string_in_one_language) {
    Bytes bytes(GN_FFS_STRINGS_MAX);
    bytes.resize(gn_ffs_strings(bytes.data()));
    EXPECT_EQ(u32(bytes, 0), 2u);
    EXPECT_EQ(u32(bytes, 4), bytes.size());
    EXPECT_EQ(u32(bytes, 8), 1u);
    EXPECT_EQ(u32(bytes, 12), 1u);
    EXPECT_EQ(part(bytes, 16, 2), (Bytes{0x09, 0x04}));
    EXPECT_EQ(std::string(bytes.begin() + 18, bytes.end()), std::string("gonio link", 11));
}

} // namespace
