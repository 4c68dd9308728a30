// scripted_can.hpp: a CAN port that records what is sent and answers only what the test says; for dialogues.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <deque>
#include <initializer_list>
#include <string>
#include <vector>

extern "C" {
#include "can.h"
}

namespace gonio::test {

struct Scripted_can {
    std::vector<gn_can_frame> sent;
    gn_can_port port{this, &send, &receive, &status};

    static int send(void *context, const gn_can_frame *frame) {
        static_cast<Scripted_can *>(context)->sent.push_back(*frame);
        return 0;
    }
    static int receive(void *, gn_can_frame *) { return 0; }
    static void status(void *, gn_can_status *status) { *status = {}; }
};

inline gn_can_frame frame_of(std::uint32_t id, std::initializer_list<int> bytes, std::int64_t stamp_ns = 0) {
    gn_can_frame frame{};
    frame.id = id;
    frame.stamp_ns = stamp_ns;
    for (int const byte : bytes) {
        frame.data[frame.length++] = static_cast<std::uint8_t>(byte);
    }
    return frame;
}

inline std::string hex(const gn_can_frame &frame) {
    static const char *digits = "0123456789ABCDEF";
    std::string text;
    for (int shift = 8; shift >= 0; shift -= 4) {
        text += digits[frame.id >> shift & 15u];
    }
    text += '#';
    for (int i = 0; i < frame.length; i++) {
        text += digits[frame.data[i] >> 4];
        text += digits[frame.data[i] & 15];
    }
    return text;
}

} // namespace gonio::test
