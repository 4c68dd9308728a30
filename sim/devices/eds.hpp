// eds.hpp: reader of electronic data sheets (CiA 306): what a device's object dictionary holds after power-up.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace gonio::sim {

// One sub-object. Limits and defaults are still text: they depend on the data type and on the node id.
struct Eds_object {
    std::uint16_t index = 0;
    std::uint8_t subindex = 0;
    std::string name;
    std::uint16_t data_type = 0; // CiA 301's number
    std::string access;          // ro, wo, rw, rwr, rww, const
    bool mappable = false;
    std::string default_text;
    std::optional<std::string> low_text, high_text;
};

struct Eds_file {
    std::string product_name;
    std::vector<Eds_object> objects;        // in ascending order of index and sub-index
    std::vector<std::uint16_t> dummy_types; // data types that an RPDO may map as a gap
};

// An object, or one sub-object of it.
struct Object_name {
    std::uint16_t index = 0;
    std::optional<std::uint8_t> subindex; // without: the object with all of its sub-objects
};

// Throws std::runtime_error naming file, section and key. A section that the object lists do not name is an error too.
Eds_file read_eds(const std::filesystem::path &path);

// "0x1F", "31", "-3", "$NODEID+0x200"; nothing if it is no number.
std::optional<std::int64_t> eds_number(const std::string &text, std::uint8_t node);

// "0x6007", "0x1400:05", all hexadecimal; nothing if it is no such name.
std::optional<Object_name> object_name(const std::string &text);
std::string object_text(const Object_name &name);

// The device lacks it. Throws std::runtime_error if it lacked it already.
void take_out(Eds_file &eds, const Object_name &name);

} // namespace gonio::sim
