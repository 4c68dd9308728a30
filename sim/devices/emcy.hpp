// emcy.hpp: emergency messages of one node, with the error register (0x1001) and the error history (0x1003).
#pragma once

#include <cstdint>

#include "can.h"
#include "object_dictionary.hpp"

namespace gonio::sim {

namespace emcy {
constexpr std::uint16_t sto = 0x5090;
constexpr std::uint16_t heartbeat_lost = 0x8130;
constexpr std::uint16_t pdo_too_short = 0x8210;
constexpr std::uint16_t pdo_too_long = 0x8220;
constexpr std::uint16_t sync_length = 0x8240;
constexpr std::uint16_t rpdo_deadline = 0x8250;
constexpr std::uint16_t following_error = 0x8611;
} // namespace emcy

class Emergency {
public:
    explicit Emergency(Object_dictionary &dictionary) : dictionary_(dictionary) {}

    // Sets the error register, adds to the history and gives the message; `detail` fills its manufacturer bytes.
    gn_can_frame raise(std::uint16_t code, std::uint32_t detail = 0);
    // All errors are gone: the message with code 0x0000.
    gn_can_frame clear();
    // After a reset: no message.
    void forget() { active_ = false; }
    [[nodiscard]] bool any() const { return active_; }
    // 0x1014 bit 31: no messages.
    [[nodiscard]] bool enabled() const;
    // Entries that hold no error cannot be read (0x0800 0024).
    static std::uint32_t check_history_read(Object_dictionary &dictionary, const Od_entry &entry);

private:
    gn_can_frame message(std::uint16_t code, std::uint32_t detail);
    Object_dictionary &dictionary_;
    bool active_ = false;
};

} // namespace gonio::sim
