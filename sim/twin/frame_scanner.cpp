// frame_scanner.cpp: cuts a byte stream into frames.
#include "frame_scanner.hpp"

#include <cstring>

namespace gonio::sim {

std::size_t frame_size(const std::uint8_t *bytes, std::size_t length) {
    if (length < sizeof(gn_frame_header)) {
        return 0;
    }
    gn_frame_header header{};
    std::memcpy(&header, bytes, sizeof header);
    return sizeof header + header.length;
}

void Frame_scanner::feed(const std::uint8_t *bytes, std::size_t length, const Found &found) {
    // Nearly always whole frames come; only what is left of them is copied.
    bool const copied = !held_.empty();
    if (copied) {
        held_.insert(held_.end(), bytes, bytes + length);
        bytes = held_.data();
        length = held_.size();
    }
    std::size_t taken = 0;
    for (;;) {
        std::size_t const size = frame_size(bytes + taken, length - taken);
        if (size == 0 || size > length - taken) {
            break;
        }
        gn_frame_header header{};
        std::memcpy(&header, bytes + taken, sizeof header);
        found(header, bytes + taken + sizeof header);
        taken += size;
    }
    std::vector<std::uint8_t> rest(bytes + taken, bytes + length);
    held_.swap(rest);
}

} // namespace gonio::sim
