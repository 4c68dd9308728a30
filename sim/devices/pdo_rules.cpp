// pdo_rules.cpp: what CiA 301 lets a client write to the PDO parameters, and when.
#include <algorithm>

#include "pdo.hpp"

namespace gonio::sim {
namespace {

constexpr std::uint32_t does_not_exist = 0x80000000U;

// Identifiers that no PDO may have (CiA 301, table of restricted COB-IDs).
bool restricted(std::uint32_t id) {
    constexpr std::array<std::array<std::uint32_t, 2>, 6> ranges{
        {{0x000, 0x07F}, {0x101, 0x180}, {0x581, 0x5FF}, {0x601, 0x67F}, {0x6E0, 0x6FF}, {0x701, 0x7FF}}};
    return std::any_of(ranges.begin(), ranges.end(),
                       [id](const auto &range) { return id >= range[0] && id <= range[1]; });
}

std::uint32_t check_communication(const Od_entry &entry, std::int64_t value, std::uint32_t cob_id) {
    const bool exists = (cob_id & does_not_exist) == 0;
    switch (entry.subindex) {
    case 1: {
        const auto wanted = static_cast<std::uint32_t>(value);
        if ((wanted & 0x3FFFF800U) != 0) { // 29-bit identifiers are not supported
            return abort_code::value_range;
        }
        if ((wanted & does_not_exist) != 0) {
            return abort_code::none;
        }
        if (restricted(wanted & 0x7FFU)) {
            return abort_code::value_range;
        }
        return exists && ((wanted ^ cob_id) & 0x3FFFFFFFU) != 0 ? abort_code::device_state : abort_code::none;
    }
    case 2: // 241-251 are reserved; 252 and 253 need remote frames
        return value > 240 && value < 254 ? abort_code::value_range : abort_code::none;
    case 3:
    case 6: // inhibit time, SYNC start value
        return exists && value != entry.value ? abort_code::device_state : abort_code::none;
    default:
        return abort_code::none;
    }
}

// One mapping entry; `bytes` gets its length.
std::uint32_t check_mapped(Object_dictionary &dictionary, bool receive, std::int64_t value, unsigned &bytes) {
    const auto index = static_cast<std::uint16_t>(value >> 16U);
    const auto subindex = static_cast<std::uint8_t>(value >> 8U);
    const auto bits = static_cast<unsigned>(value & 0xFF);
    bytes = bits / 8;
    if (index <= 7) {
        constexpr std::array<unsigned, 8> dummy_bits{0, 1, 8, 16, 32, 8, 16, 32};
        const auto &dummies = dictionary.dummy_types();
        const bool offered = std::find(dummies.begin(), dummies.end(), index) != dummies.end();
        if (!offered) {
            return abort_code::no_object;
        }
        return receive && subindex == 0 && bits == dummy_bits[index] ? abort_code::none : abort_code::not_mappable;
    }
    const Od_entry *entry = dictionary.find(index, subindex);
    if (entry == nullptr) {
        return dictionary.has_index(index) ? abort_code::no_subindex : abort_code::no_object;
    }
    const bool direction = receive ? entry->writable : entry->readable;
    return entry->mappable && direction && bits == 8U * entry->size ? abort_code::none : abort_code::not_mappable;
}

std::uint32_t check_mapping(Object_dictionary &dictionary, const Od_entry &entry, std::int64_t value) {
    const bool receive = entry.index < 0x1800;
    const Od_entry &cob_id = dictionary.at(static_cast<std::uint16_t>(entry.index - 0x200), 1);
    if ((cob_id.value & does_not_exist) == 0) {
        return abort_code::device_state;
    }
    unsigned bytes = 0;
    if (entry.subindex != 0) {
        if (dictionary.at(entry.index, 0).value != 0) {
            return abort_code::device_state;
        }
        return value == 0 ? abort_code::none : check_mapped(dictionary, receive, value, bytes);
    }
    unsigned total = 0;
    for (std::int64_t k = 1; k <= value; ++k) {
        const std::int64_t mapped = dictionary.at(entry.index, static_cast<std::uint8_t>(k)).value;
        if (const std::uint32_t code = check_mapped(dictionary, receive, mapped, bytes); code != abort_code::none) {
            return code;
        }
        total += bytes;
    }
    return total > 8 ? abort_code::mapping_too_long : abort_code::none;
}

} // namespace

std::uint32_t check_pdo_write(Object_dictionary &dictionary, const Od_entry &entry, std::int64_t value) {
    if ((entry.index & 0x0200U) != 0) { // 0x1600, 0x1A00
        return check_mapping(dictionary, entry, value);
    }
    return check_communication(entry, value, static_cast<std::uint32_t>(dictionary.at(entry.index, 1).value));
}

} // namespace gonio::sim
