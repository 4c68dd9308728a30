// scripted_host.hpp: a host for tests that says on a real socket what the test tells it to.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <pb_encode.h>
#include <sys/socket.h>
#include <unistd.h>

#include "gonio.pb.h"
#include "gonio_records.h"
#include "lockstep_link.hpp"

extern "C" {
#include "frame.h"
}

namespace gonio::sim {

using Bytes = std::vector<std::uint8_t>;

inline Bytes frame(std::uint32_t kind, std::uint32_t sequence, std::uint32_t acknowledged, const Bytes &payload = {}) {
    Bytes bytes(GN_FRAME_HEADER_SIZE + payload.size());
    std::copy(payload.begin(), payload.end(), bytes.begin() + GN_FRAME_HEADER_SIZE);
    gn_frame_begin(bytes.data(), kind, sequence, static_cast<std::uint32_t>(payload.size()));
    gn_frame_seal(bytes.data(), acknowledged);
    return bytes;
}

inline Bytes hello(gonio_Role role) {
    gonio_Hello message = gonio_Hello_init_zero;
    message.schema_hash = GN_SCHEMA_HASH;
    message.role = role;
    Bytes payload(gonio_Hello_size);
    pb_ostream_t stream = pb_ostream_from_buffer(payload.data(), payload.size());
    EXPECT_TRUE(pb_encode(&stream, gonio_Hello_fields, &message));
    payload.resize(stream.bytes_written);
    return frame(GN_FRAME_HELLO, 0, 0, payload);
}

class Host {
public:
    explicit Host(const Lockstep_link &link) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
        std::string const address = link.address();
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr *>(&to), sizeof to), 0);
    }
    ~Host() { hang_up(); }
    Host(const Host &) = delete;
    Host &operator=(const Host &) = delete;
    void say(const Bytes &bytes) const {
        EXPECT_EQ(send(socket_, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    }
    void hang_up() {
        if (socket_ >= 0) {
            close(socket_);
            socket_ = -1;
        }
    }
    // How many bytes came; 0: the other side has closed.
    [[nodiscard]] std::size_t hear() const { return hear_bytes().size(); }
    [[nodiscard]] Bytes hear_bytes() const {
        Bytes bytes(100000);
        ssize_t const length = recv(socket_, bytes.data(), bytes.size(), 0);
        bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
        return bytes;
    }

private:
    int socket_;
};

} // namespace gonio::sim
