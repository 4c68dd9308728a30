// real_bench.hpp: an apparatus in real mode whose time the test sets, and sockets to talk to what is under test.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "apparatus.hpp"
#include "can_bus.hpp"
#include "edge.h"

namespace gonio::sim {

// A socket that takes at most this long to say something; only a failing test waits so long.
constexpr int patience_s = 10;

inline Scenario demo() {
    return load_scenario(GONIO_SOURCE_DIR "/sim/scenarios/demo.toml", GONIO_SOURCE_DIR);
}

struct Real_bench {
    explicit Real_bench(const Scenario &scenario = demo(), std::int64_t start_ns = 1000000000)
        : apparatus(scenario, {}, closed_form_optics,
                    {[this](std::uint32_t line, bool level) { lines.emplace_back(line, level); },
                     {},
                     [this](bool high) { lines.emplace_back(GN_LINE_STROBE, high); },
                     [this] { ++packets; },
                     {}},
                    {start_ns, Can_bus::no_bit_times, true}) {
        apparatus.arm_faults();
    }
    void run_ms(double duration_ms) {
        std::int64_t const end_ns = apparatus.scheduler().now_ns() + static_cast<std::int64_t>(duration_ms * 1e6);
        while (apparatus.scheduler().run_one(end_ns)) {
        }
    }
    std::vector<std::pair<std::uint32_t, bool>> lines;
    int packets = 0;
    Apparatus apparatus;
};

// The other end of a connection.
class Peer {
public:
    explicit Peer(int descriptor) : socket_(descriptor) {
        timeval const limit{patience_s, 0};
        setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    }
    static Peer tcp(std::uint16_t port) {
        int const descriptor = socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port);
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(connect(descriptor, reinterpret_cast<const sockaddr *>(&to), sizeof to), 0);
        return Peer(descriptor);
    }
    ~Peer() { hang_up(); }
    Peer(const Peer &) = delete;
    Peer &operator=(const Peer &) = delete;
    void hang_up() {
        if (socket_ >= 0) {
            close(socket_);
            socket_ = -1;
        }
    }
    void say(const std::string &text) const {
        EXPECT_EQ(send(socket_, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
    }
    template <typename Block> void say_block(const Block &block) const {
        EXPECT_EQ(send(socket_, &block, sizeof block, MSG_NOSIGNAL), static_cast<ssize_t>(sizeof block));
    }
    // What is there; empty: nothing is.
    [[nodiscard]] std::string hear_now() const { return receive(MSG_DONTWAIT); }
    [[nodiscard]] std::string hear() const { return receive(0); }

private:
    [[nodiscard]] std::string receive(int flags) const {
        std::string text(100000, '\0');
        ssize_t const length = recv(socket_, text.data(), text.size(), flags);
        text.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
        return text;
    }
    int socket_;
};

} // namespace gonio::sim
