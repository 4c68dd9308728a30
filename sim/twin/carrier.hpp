// carrier.hpp: what carries the link's bytes between the firmware in the twin and its host: sockets, or a host in the
// same process.
#pragma once

#include <cstddef>
#include <cstdint>

namespace gonio::sim {

class Carrier {
public:
    virtual ~Carrier() = default;
    // As gn_link_port has them.
    virtual int read(std::uint32_t client, std::uint8_t *buffer, std::size_t capacity) = 0;
    virtual int write(std::uint32_t client, const std::uint8_t *bytes, std::size_t length) = 0;
    virtual void close(std::uint32_t client) = 0;
    // The last byte of the firmware's frame with this sequence number (0: not numbered) was written at now_ns.
    virtual void frame_sent(std::uint32_t client, std::uint32_t sequence, std::int64_t now_ns) = 0;
    // Nothing that the driver sends arrives any more.
    virtual void silence_host() = 0;
};

} // namespace gonio::sim
