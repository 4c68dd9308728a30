// eds.cpp: reader of electronic data sheets (CiA 306).
#include "eds.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>

namespace gonio::sim {
namespace {

using Section = std::map<std::string, std::string>; // keys in lower case

std::string trimmed(const std::string &text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string::npos) {
        return {};
    }
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
    return text;
}

std::optional<unsigned> hexadecimal(const std::string &digits) {
    unsigned value = 0;
    const char *const last = digits.data() + digits.size();
    const auto [end, error] = std::from_chars(digits.data(), last, value, 16);
    return error == std::errc() && end == last ? std::optional(value) : std::nullopt;
}

class Reader {
public:
    explicit Reader(const std::filesystem::path &path) : path_(path) {
        std::ifstream file(path);
        if (!file) {
            throw std::runtime_error(path.string() + ": cannot be opened");
        }
        std::string line;
        Section *section = nullptr;
        for (int number = 1; std::getline(file, line); ++number) {
            line = trimmed(line);
            if (line.empty() || line.front() == ';') {
                continue;
            }
            if (line.front() == '[' && line.back() == ']') {
                const auto [place, fresh] = sections_.try_emplace(lower(line.substr(1, line.size() - 2)));
                if (!fresh) {
                    fail(line, "the section is there twice");
                }
                section = &place->second;
                continue;
            }
            const auto equals = line.find('=');
            if (equals == std::string::npos || section == nullptr) {
                fail("line " + std::to_string(number), "neither a section nor key=value");
            }
            (*section)[lower(trimmed(line.substr(0, equals)))] = trimmed(line.substr(equals + 1));
        }
    }

    Eds_file read() {
        Eds_file eds;
        eds.product_name = text("deviceinfo", "productname");
        for (std::uint16_t type = 1; type <= 7; ++type) {
            const auto dummies = sections_.find("dummyusage");
            const std::string key = "dummy000" + std::to_string(type);
            if (dummies != sections_.end() && dummies->second.contains(key) && number("dummyusage", key) == 1) {
                eds.dummy_types.push_back(type);
            }
        }
        for (const char *list : {"mandatoryobjects", "optionalobjects", "manufacturerobjects"}) {
            const std::int64_t count = number(list, "supportedobjects");
            for (std::int64_t k = 1; k <= count; ++k) {
                read_object(eds, static_cast<std::uint16_t>(number(list, std::to_string(k))));
            }
        }
        for (const auto &[name, section] : sections_) {
            const bool is_object =
                name.size() >= 4 && std::all_of(name.begin(), name.begin() + 4,
                                                [](unsigned char letter) { return std::isxdigit(letter) != 0; });
            if (is_object && !used_.contains(name)) {
                fail(name, "no object list names it");
            }
        }
        std::sort(eds.objects.begin(), eds.objects.end(), [](const Eds_object &a, const Eds_object &b) {
            return a.index != b.index ? a.index < b.index : a.subindex < b.subindex;
        });
        return eds;
    }

private:
    [[noreturn]] void fail(const std::string &where, const std::string &what) const {
        throw std::runtime_error(path_.string() + ": " + where + ": " + what);
    }
    const std::string &text(const std::string &section, const std::string &key) const {
        const auto place = sections_.find(section);
        if (place == sections_.end()) {
            fail("[" + section + "]", "the section is missing");
        }
        const auto value = place->second.find(key);
        if (value == place->second.end()) {
            fail("[" + section + "]", "the key " + key + " is missing");
        }
        return value->second;
    }
    std::int64_t number(const std::string &section, const std::string &key) const {
        const auto value = eds_number(text(section, key), 0);
        if (!value) {
            fail("[" + section + "] " + key, "not a number: " + text(section, key));
        }
        return *value;
    }
    bool has(const std::string &section, const std::string &key) const {
        const auto place = sections_.find(section);
        return place != sections_.end() && place->second.contains(key) && !place->second.at(key).empty();
    }

    Eds_object read_entry(const std::string &section, std::uint16_t index, std::uint8_t subindex) {
        used_.insert(section);
        Eds_object object;
        object.index = index;
        object.subindex = subindex;
        object.name = text(section, "parametername");
        object.data_type = static_cast<std::uint16_t>(number(section, "datatype"));
        object.access = lower(text(section, "accesstype"));
        object.mappable = has(section, "pdomapping") && number(section, "pdomapping") != 0;
        object.default_text = has(section, "defaultvalue") ? text(section, "defaultvalue") : "";
        if (has(section, "lowlimit")) {
            object.low_text = text(section, "lowlimit");
        }
        if (has(section, "highlimit")) {
            object.high_text = text(section, "highlimit");
        }
        return object;
    }

    void read_object(Eds_file &eds, std::uint16_t index) {
        static const char *const digits = "0123456789abcdef";
        std::string section;
        for (int shift = 12; shift >= 0; shift -= 4) {
            section += digits[(index >> shift) & 0xF];
        }
        constexpr std::int64_t variable = 7, array = 8, record = 9;
        const std::int64_t kind = has(section, "objecttype") ? number(section, "objecttype") : variable;
        if (kind == variable) {
            eds.objects.push_back(read_entry(section, index, 0));
            return;
        }
        if (kind != array && kind != record) {
            fail("[" + section + "]", "object type " + std::to_string(kind) + " is not supported");
        }
        used_.insert(section);
        const std::int64_t expected = number(section, "subnumber");
        std::int64_t found = 0;
        for (unsigned subindex = 0; subindex < 0xFF; ++subindex) {
            std::string name = section + "sub";
            name += subindex > 0xF ? std::string(1, digits[subindex >> 4]) : std::string();
            name += digits[subindex & 0xF];
            if (sections_.contains(name)) {
                eds.objects.push_back(read_entry(name, index, static_cast<std::uint8_t>(subindex)));
                ++found;
            }
        }
        if (found != expected) {
            fail("[" + section + "]", "SubNumber says " + std::to_string(expected) + ", there are " +
                                          std::to_string(found) + " sub-objects");
        }
    }

    std::filesystem::path path_;
    std::map<std::string, Section> sections_;
    std::set<std::string> used_;
};

} // namespace

std::optional<std::int64_t> eds_number(const std::string &text, std::uint8_t node) {
    std::string rest;
    for (const char letter : lower(text)) {
        if (letter != ' ') {
            rest += letter;
        }
    }
    std::int64_t offset = 0;
    const std::string token = "$nodeid";
    if (const auto place = rest.find(token); place != std::string::npos) {
        offset = node;
        rest.erase(place, token.size());
        std::erase(rest, '+');
        if (rest.empty()) {
            return offset;
        }
    }
    std::size_t used = 0;
    try {
        const std::int64_t value = std::stoll(rest, &used, 0);
        if (used == rest.size()) {
            return value + offset;
        }
    } catch (const std::logic_error &) {
        return std::nullopt;
    }
    return std::nullopt;
}

Eds_file read_eds(const std::filesystem::path &path) {
    return Reader(path).read();
}

std::optional<Object_name> object_name(const std::string &text) {
    constexpr std::size_t index_length = 6, whole_length = 9; // 0x1400, 0x1400:05
    const bool whole = text.size() == whole_length && text[index_length] == ':';
    if (!text.starts_with("0x") || (text.size() != index_length && !whole)) {
        return std::nullopt;
    }
    const auto index = hexadecimal(text.substr(2, 4));
    const auto subindex = whole ? hexadecimal(text.substr(index_length + 1)) : 0;
    if (!index || !subindex) {
        return std::nullopt;
    }
    Object_name name{static_cast<std::uint16_t>(*index), std::nullopt};
    if (whole) {
        name.subindex = static_cast<std::uint8_t>(*subindex);
    }
    return name;
}

std::string object_text(const Object_name &name) {
    std::array<char, 10> text{};
    if (name.subindex) {
        std::snprintf(text.data(), text.size(), "0x%04X:%02X", +name.index, +*name.subindex);
    } else {
        std::snprintf(text.data(), text.size(), "0x%04X", +name.index);
    }
    return text.data();
}

void take_out(Eds_file &eds, const Object_name &name) {
    const auto taken = std::erase_if(eds.objects, [&name](const Eds_object &object) {
        return object.index == name.index && object.subindex == name.subindex.value_or(object.subindex);
    });
    if (taken == 0) {
        throw std::runtime_error(eds.product_name + ": there is no object " + object_text(name) + " to take out");
    }
}

} // namespace gonio::sim
