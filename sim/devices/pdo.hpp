// pdo.hpp: process data objects as their communication and mapping parameters in the object dictionary demand.
#pragma once

#include <array>
#include <cstdint>

#include "can.h"
#include "object_dictionary.hpp"

namespace gonio::sim {

// The rules of CiA 301 for writing to 0x1400-0x1BFF: an abort code, or abort_code::none. The mapping may change only
// while the PDO does not exist (COB-ID bit 31) and its number of entries is 0.
std::uint32_t check_pdo_write(Object_dictionary &dictionary, const Od_entry &entry, std::int64_t value);

// The parameters of one PDO; pointers into the dictionary are resolved when the parameters change, not per frame.
class Pdo {
public:
    // communication 0x1400+n with mapping 0x1600+n, or 0x1800+n with 0x1A00+n.
    Pdo(Object_dictionary &dictionary, std::uint16_t communication, std::uint16_t mapping);
    // Read the parameters again.
    void refresh();

    [[nodiscard]] bool exists() const { return exists_; }
    [[nodiscard]] std::uint32_t id() const { return id_; }
    [[nodiscard]] unsigned bytes() const { return bytes_; }
    [[nodiscard]] bool synchronous() const { return type_ <= 240; }

protected:
    struct Mapped {
        Od_entry *entry; // nullptr: a gap
        unsigned bytes;
    };
    Object_dictionary &dictionary_;
    std::uint16_t communication_;
    std::uint16_t mapping_;
    std::array<Mapped, 8> mapped_{};
    unsigned count_ = 0;
    unsigned bytes_ = 0;
    bool exists_ = false;
    std::uint32_t id_ = 0;
    unsigned type_ = 255;
    std::int64_t event_timer_ns_ = 0;
};

enum class Rpdo_result { taken, waits_for_sync, too_short, too_long };

class Rpdo : public Pdo {
public:
    using Pdo::Pdo;
    // A frame with this PDO's identifier. Too long ones are taken as far as they are mapped.
    Rpdo_result receive(const gn_can_frame &frame);
    // Take over what came since the last SYNC; false if nothing did.
    bool take_over();
    // True once when the event timer ran out after the last reception (deadline monitoring).
    bool deadline_missed(std::int64_t now_ns);
    void disarm() { armed_ = waiting_ = false; }

private:
    void unpack();
    std::array<std::uint8_t, 8> data_{};
    bool waiting_ = false;
    bool armed_ = false;
    std::int64_t received_ns_ = 0;
};

class Tpdo : public Pdo {
public:
    Tpdo(Object_dictionary &dictionary, std::uint16_t communication, std::uint16_t mapping);
    void refresh();
    // Whether this SYNC asks for the PDO; counter 0 if SYNC carries none.
    bool due_at_sync(std::uint8_t counter);
    // Whether an event-driven PDO (254, 255) is to be sent: a mapped value changed or the event timer ran out, and the
    // inhibit time has passed.
    bool due_by_event(std::int64_t now_ns);
    gn_can_frame pack(std::int64_t now_ns);
    // After NMT start: forget what was sent before.
    void restart();

private:
    [[nodiscard]] std::array<std::uint8_t, 8> values() const;
    std::array<std::uint8_t, 8> last_{};
    bool sent_ = false;
    std::int64_t sent_ns_ = 0;
    std::int64_t inhibit_ns_ = 0;
    unsigned syncs_ = 0;
    unsigned start_value_ = 0;
    bool started_ = false;
};

} // namespace gonio::sim
