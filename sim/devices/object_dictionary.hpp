// object_dictionary.hpp: a device's objects, their values and their limits, as its EDS describes them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "eds.hpp"

namespace gonio::sim {

// SDO abort codes (CiA 301, 7.2.4.3.17).
namespace abort_code {
constexpr std::uint32_t none = 0;
constexpr std::uint32_t toggle_not_alternated = 0x05030000;
constexpr std::uint32_t timed_out = 0x05040000;
constexpr std::uint32_t unknown_command = 0x05040001;
constexpr std::uint32_t write_only = 0x06010001;
constexpr std::uint32_t read_only = 0x06010002;
constexpr std::uint32_t no_object = 0x06020000;
constexpr std::uint32_t not_mappable = 0x06040041;
constexpr std::uint32_t mapping_too_long = 0x06040042;
constexpr std::uint32_t parameter_incompatible = 0x06040043;
constexpr std::uint32_t wrong_length = 0x06070010;
constexpr std::uint32_t no_subindex = 0x06090011;
constexpr std::uint32_t value_range = 0x06090030;
constexpr std::uint32_t device_state = 0x08000022;
constexpr std::uint32_t no_data = 0x08000024;
} // namespace abort_code

struct Od_entry {
    std::uint16_t index = 0;
    std::uint8_t subindex = 0;
    std::uint8_t size = 0; // bytes; of a string, its length
    bool is_string = false;
    bool is_signed = false;
    bool readable = false;
    bool writable = false;
    bool mappable = false;
    std::int64_t value = 0;
    std::int64_t default_value = 0;
    std::int64_t low = 0;
    std::int64_t high = 0;
    std::string text; // of a string
    std::string name;
};

// Entries stay where they are: PDOs and the drive keep pointers to them.
class Object_dictionary {
public:
    // Throws std::runtime_error for a data type or value that it cannot hold.
    Object_dictionary(const Eds_file &eds, std::uint8_t node);

    // nullptr if there is none.
    [[nodiscard]] Od_entry *find(std::uint16_t index, std::uint8_t subindex = 0);
    [[nodiscard]] bool has_index(std::uint16_t index) const;
    // For objects that every drive must have; throws std::runtime_error if it is missing.
    [[nodiscard]] Od_entry &at(std::uint16_t index, std::uint8_t subindex = 0);
    [[nodiscard]] const std::vector<std::uint16_t> &dummy_types() const { return dummy_types_; }
    [[nodiscard]] const std::vector<Od_entry> &entries() const { return entries_; }

    // Power-up values of the indices first..last.
    void reset(std::uint16_t first, std::uint16_t last);

private:
    std::vector<Od_entry> entries_;
    std::vector<std::uint16_t> dummy_types_;
};

// The object's value from little-endian bytes, sign-extended if the type has a sign.
std::int64_t value_from_bytes(const std::uint8_t *bytes, unsigned size, bool is_signed);
void value_to_bytes(std::int64_t value, std::uint8_t *bytes, unsigned size);

} // namespace gonio::sim
