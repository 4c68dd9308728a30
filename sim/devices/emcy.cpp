// emcy.cpp: emergency messages, error register and error history.
#include "emcy.hpp"

#include <algorithm>

namespace gonio::sim {
namespace {

constexpr std::uint16_t history_index = 0x1003;
constexpr std::int64_t history_depth = 8;

// Bits of 0x1001: generic always; the class of the code names the other.
std::int64_t register_bits(std::uint16_t code) {
    constexpr std::int64_t generic = 0x01, current = 0x02, voltage = 0x04, temperature = 0x08, communication = 0x10,
                           profile = 0x20, manufacturer = 0x80;
    switch (code >> 12U) {
    case 0x2:
        return generic | current;
    case 0x3:
        return generic | voltage;
    case 0x4:
        return generic | temperature;
    case 0x8:
        return generic | (code < 0x8300 ? communication : profile);
    case 0xF:
        return generic | manufacturer;
    default:
        return generic;
    }
}

} // namespace

gn_can_frame Emergency::message(std::uint16_t code, std::uint32_t detail) {
    gn_can_frame frame{};
    frame.id = static_cast<std::uint32_t>(dictionary_.at(0x1014).value) & 0x7FFU;
    frame.length = 8;
    value_to_bytes(code, frame.data, 2);
    frame.data[2] = static_cast<std::uint8_t>(dictionary_.at(0x1001).value);
    value_to_bytes(detail, &frame.data[3], 4);
    return frame;
}

bool Emergency::enabled() const {
    return (dictionary_.at(0x1014).value & 0x80000000) == 0;
}

gn_can_frame Emergency::raise(std::uint16_t code, std::uint32_t detail) {
    active_ = true;
    dictionary_.at(0x1001).value |= register_bits(code);
    Od_entry &count = dictionary_.at(history_index, 0);
    count.value = std::min(count.value + 1, history_depth);
    for (std::int64_t k = count.value; k > 1; --k) {
        dictionary_.at(history_index, static_cast<std::uint8_t>(k)).value =
            dictionary_.at(history_index, static_cast<std::uint8_t>(k - 1)).value;
    }
    dictionary_.at(history_index, 1).value = code | static_cast<std::int64_t>(detail & 0xFFFFU) << 16U;
    return message(code, detail);
}

gn_can_frame Emergency::clear() {
    active_ = false;
    dictionary_.at(0x1001).value = 0;
    return message(0, 0);
}

std::uint32_t Emergency::check_history_read(Object_dictionary &dictionary, const Od_entry &entry) {
    return entry.subindex > dictionary.at(history_index, 0).value ? abort_code::no_data : abort_code::none;
}

} // namespace gonio::sim
