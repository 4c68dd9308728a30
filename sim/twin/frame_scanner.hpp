// frame_scanner.hpp: finds the frames in a stream of link bytes (protocol/link.md) without judging them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "gonio_records.h"

namespace gonio::sim {

class Frame_scanner {
public:
    // The payload is valid during the call only.
    using Found = std::function<void(const gn_frame_header &header, const std::uint8_t *payload)>;

    // Calls `found` for each frame that these bytes complete.
    void feed(const std::uint8_t *bytes, std::size_t length, const Found &found);
    void reset() { held_.clear(); }

private:
    std::vector<std::uint8_t> held_; // the beginning of a frame
};

// Bytes of the frame at `bytes`, header included; 0: the header is not whole.
std::size_t frame_size(const std::uint8_t *bytes, std::size_t length);

} // namespace gonio::sim
