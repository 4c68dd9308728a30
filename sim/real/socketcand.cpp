// socketcand.cpp: "< open can0 >", "< rawmode >", "< send 601 8 40 0 10 0 0 0 0 0 >", "< frame 581 12.345678
// 4300100092010200 >".
#include "socketcand.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tcp.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t settle_ns = 50000000;          // in which a client has read the answer to "rawmode"
constexpr std::size_t longest_command = 200;          // bytes; a frame takes 40
constexpr std::size_t most_waiting_bytes = 1U << 20U; // of a client that does not read

std::string text_of(const gn_can_frame &frame) {
    std::array<char, 64> head{};
    std::snprintf(head.data(), head.size(), "< frame %03X %.6f ", frame.id, 1e-9 * static_cast<double>(frame.stamp_ns));
    std::string text = head.data();
    for (std::uint8_t i = 0; i < frame.length; ++i) {
        std::array<char, 4> byte{};
        std::snprintf(byte.data(), byte.size(), "%02X", frame.data[i]);
        text += byte.data();
    }
    return text + " >";
}

// "send 601 8 40 0 10 0 0 0 0 0": standard identifiers only; a remote frame (fewer bytes than it says) is none.
bool parse_send(std::istringstream &words, gn_can_frame &frame) {
    unsigned length = 0;
    std::string id;
    if (!(words >> id >> std::hex >> length) || id.size() != 3 || length > sizeof frame.data) {
        return false;
    }
    frame.id = static_cast<std::uint32_t>(std::strtoul(id.c_str(), nullptr, 16));
    frame.length = static_cast<std::uint8_t>(length);
    for (unsigned i = 0; i < length; ++i) {
        unsigned byte = 0;
        if (!(words >> std::hex >> byte) || byte > 0xFF) {
            return false;
        }
        frame.data[i] = static_cast<std::uint8_t>(byte);
    }
    return frame.id <= 0x7FF;
}

} // namespace

Socketcand::Socketcand(Scheduler &scheduler, const std::string &host, std::uint16_t port)
    : scheduler_(scheduler), listener_(listen_tcp("--can socketcand:", host, port)) {}

Socketcand::~Socketcand() {
    for (const Client &client : clients_) {
        close(client.socket);
    }
    close(listener_);
}

std::uint16_t Socketcand::port() const {
    return tcp_port(listener_);
}

void Socketcand::wait_for(std::vector<pollfd> &descriptors) const {
    descriptors.push_back({listener_, POLLIN, 0});
    for (const Client &client : clients_) {
        descriptors.push_back(
            {client.socket, static_cast<short>(client.outgoing.empty() ? POLLIN : POLLIN | POLLOUT), 0});
    }
}

void Socketcand::serve() {
    accept_clients();
    clients_.remove_if([this](Client &client) {
        bool const here = receive(client) && flush(client);
        if (!here) {
            close(client.socket);
        }
        return !here;
    });
}

void Socketcand::accept_clients() {
    for (;;) {
        int const socket = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (socket < 0) {
            return;
        }
        int const on = 1;
        setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        clients_.push_back({socket, {}, "< hi >"});
    }
}

bool Socketcand::receive(Client &client) {
    return receive_commands(client.socket, client.incoming, longest_command, [&] {
        std::size_t end = 0;
        while ((end = client.incoming.find('>')) != std::string::npos) {
            std::size_t const begin = client.incoming.rfind('<', end);
            if (begin != std::string::npos) {
                obey(client, client.incoming.substr(begin + 1, end - begin - 1));
            }
            client.incoming.erase(0, end + 1);
        }
        return true;
    });
}

void Socketcand::obey(Client &client, const std::string &command) {
    std::istringstream words(command);
    std::string verb;
    words >> verb;
    if (verb == "send" && client.raw) {
        client.frames_from_ns = 0;
        gn_can_frame frame{};
        if (parse_send(words, frame)) {
            frame.stamp_ns = monotonic_ns();
            tell(&client, frame);
            hear(frame);
        }
    } else if (verb == "open") {
        client.outgoing += "< ok >";
    } else if (verb == "rawmode") {
        client.outgoing += "< ok >";
        client.raw = true;
        client.frames_from_ns = monotonic_ns() + settle_ns;
    } else if (verb == "echo") {
        client.outgoing += "< echo >";
    } else {
        client.outgoing += "< error unknown command >";
    }
}

void Socketcand::send(const gn_can_frame &frame) {
    tell(nullptr, frame);
}

void Socketcand::tell(const Client *except, const gn_can_frame &frame) {
    std::string const text = text_of(frame);
    for (Client &client : clients_) {
        if (&client == except || !client.raw || scheduler_.now_ns() < client.frames_from_ns) {
            continue;
        }
        if (client.outgoing.size() + text.size() > most_waiting_bytes) {
            ++dropped_;
            continue;
        }
        client.outgoing += text;
        flush(client); // what does not leave now leaves when the socket can take it
    }
}

bool Socketcand::flush(Client &client) {
    while (!client.outgoing.empty()) {
        ssize_t const sent = ::send(client.socket, client.outgoing.data(), client.outgoing.size(), MSG_NOSIGNAL);
        if (sent < 0) {
            return errno == EAGAIN || errno == EINTR;
        }
        client.outgoing.erase(0, static_cast<std::size_t>(sent));
    }
    return true;
}

} // namespace gonio::sim
