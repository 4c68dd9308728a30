// object_dictionary.cpp: a device's objects, their values and their limits.
#include "object_dictionary.hpp"

#include <algorithm>
#include <stdexcept>

namespace gonio::sim {
namespace {

constexpr std::uint16_t visible_string = 9;

std::string place(const Eds_object &object) {
    return "object " + std::to_string(object.index) + "." + std::to_string(object.subindex) + " (" + object.name + ")";
}

void set_type(const Eds_object &object, Od_entry &entry) {
    switch (object.data_type) {
    case 1: // BOOLEAN
    case 5: // UNSIGNED8
        entry.size = 1;
        break;
    case 6: // UNSIGNED16
        entry.size = 2;
        break;
    case 7: // UNSIGNED32
        entry.size = 4;
        break;
    case 2: // INTEGER8
        entry.size = 1;
        entry.is_signed = true;
        break;
    case 3: // INTEGER16
        entry.size = 2;
        entry.is_signed = true;
        break;
    case 4: // INTEGER32
        entry.size = 4;
        entry.is_signed = true;
        break;
    case visible_string:
        entry.size = static_cast<std::uint8_t>(std::min<std::size_t>(object.default_text.size(), 255));
        entry.is_string = true;
        entry.text = object.default_text.substr(0, entry.size);
        return;
    default:
        throw std::runtime_error(place(object) + ": data type " + std::to_string(object.data_type) + " is not known");
    }
    const std::int64_t span = std::int64_t{1} << (8 * entry.size);
    entry.low = entry.is_signed ? -span / 2 : 0;
    entry.high = entry.is_signed ? span / 2 - 1 : span - 1;
}

void set_values(const Eds_object &object, std::uint8_t node, Od_entry &entry) {
    const auto number = [&](const std::string &text, const char *what) {
        const auto value = eds_number(text, node);
        if (!value || *value < entry.low || *value > entry.high) {
            throw std::runtime_error(place(object) + ": " + what + " does not fit: " + text);
        }
        return *value;
    };
    if (!object.default_text.empty()) {
        entry.default_value = number(object.default_text, "default value");
        entry.value = entry.default_value;
    }
    const std::int64_t low = object.low_text ? number(*object.low_text, "low limit") : entry.low;
    const std::int64_t high = object.high_text ? number(*object.high_text, "high limit") : entry.high;
    entry.low = low;
    entry.high = high;
}

} // namespace

Object_dictionary::Object_dictionary(const Eds_file &eds, std::uint8_t node) : dummy_types_(eds.dummy_types) {
    entries_.reserve(eds.objects.size());
    for (const Eds_object &object : eds.objects) {
        Od_entry entry;
        entry.index = object.index;
        entry.subindex = object.subindex;
        entry.name = object.name;
        entry.mappable = object.mappable;
        entry.readable = object.access != "wo";
        entry.writable = object.access != "ro" && object.access != "const";
        set_type(object, entry);
        if (!entry.is_string) {
            set_values(object, node, entry);
        }
        entries_.push_back(std::move(entry));
    }
}

Od_entry *Object_dictionary::find(std::uint16_t index, std::uint8_t subindex) {
    const auto found = std::lower_bound(entries_.begin(), entries_.end(), std::pair(index, subindex),
                                        [](const Od_entry &entry, const std::pair<std::uint16_t, std::uint8_t> &key) {
                                            return std::pair(entry.index, entry.subindex) < key;
                                        });
    const bool hit = found != entries_.end() && found->index == index && found->subindex == subindex;
    return hit ? &*found : nullptr;
}

bool Object_dictionary::has_index(std::uint16_t index) const {
    return std::any_of(entries_.begin(), entries_.end(), [&](const Od_entry &entry) { return entry.index == index; });
}

Od_entry &Object_dictionary::at(std::uint16_t index, std::uint8_t subindex) {
    Od_entry *entry = find(index, subindex);
    if (entry == nullptr) {
        throw std::runtime_error("the drive cannot be without object " + object_text({index, subindex}));
    }
    return *entry;
}

void Object_dictionary::reset(std::uint16_t first, std::uint16_t last) {
    for (Od_entry &entry : entries_) {
        if (entry.index >= first && entry.index <= last) {
            entry.value = entry.default_value;
        }
    }
}

std::int64_t value_from_bytes(const std::uint8_t *bytes, unsigned size, bool is_signed) {
    std::uint64_t value = 0;
    for (unsigned k = 0; k < size; ++k) {
        value |= static_cast<std::uint64_t>(bytes[k]) << (8 * k);
    }
    if (is_signed && size < 8 && (bytes[size - 1] & 0x80U) != 0) {
        value |= ~std::uint64_t{0} << (8 * size);
    }
    return static_cast<std::int64_t>(value);
}

void value_to_bytes(std::int64_t value, std::uint8_t *bytes, unsigned size) {
    for (unsigned k = 0; k < size; ++k) {
        bytes[k] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * k));
    }
}

} // namespace gonio::sim
