// lockstep_link.cpp: sockets, and the rule by which host and virtual time keep step.
#include "lockstep_link.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <pb_decode.h>

#include "frame_scanner.hpp"
#include "gonio.pb.h"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t answer_ns = 1000000; // a host frame arrives this long after the frame that it answers
constexpr std::size_t chunk_bytes = 1U << 18U;
constexpr std::size_t most_waiting_bytes = 8U << 20U; // a client that does not read is cut off from the stream here
constexpr std::uint16_t magic = 0x4E47;

sockaddr_in address_of(int socket, bool peer) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    auto *generic = reinterpret_cast<sockaddr *>(&address);
    if ((peer ? getpeername(socket, generic, &size) : getsockname(socket, generic, &size)) != 0) {
        address.sin_port = 0;
    }
    return address;
}

std::string text_of(const sockaddr_in &address) {
    std::array<char, INET_ADDRSTRLEN> text{};
    inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
    return std::string(text.data()) + ":" + std::to_string(ntohs(address.sin_port));
}

bool says_driver(const std::uint8_t *payload, std::size_t length) {
    gonio_Hello hello = gonio_Hello_init_zero;
    pb_istream_t stream = pb_istream_from_buffer(payload, length);
    return pb_decode(&stream, gonio_Hello_fields, &hello) && hello.role == gonio_Role_ROLE_DRIVER;
}

} // namespace

Lockstep_link::Lockstep_link(const std::string &host, std::uint16_t port, bool paced)
    : listener_(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)), paced_(paced), chunk_(chunk_bytes) {
    int const on = 1;
    setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    if (inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1 ||
        bind(listener_, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0 ||
        listen(listener_, 4) != 0) {
        std::string const why = std::strerror(errno);
        ::close(listener_);
        throw Input_error("--listen " + host + ":" + std::to_string(port) + ": cannot listen there (" + why +
                          "); use 127.0.0.1:0");
    }
}

Lockstep_link::~Lockstep_link() {
    for (Client &client : clients_) {
        flush(client);
        hang_up(client);
    }
    ::close(listener_);
}

std::string Lockstep_link::address() const {
    return text_of(address_of(listener_, false));
}

int Lockstep_link::read(std::uint32_t client, std::uint8_t *buffer, std::size_t capacity) {
    Client &c = clients_.at(client);
    if (!c.connected) {
        return -1;
    }
    std::size_t const length = std::min(capacity, c.readable.size() - c.read_from);
    std::copy_n(c.readable.begin() + static_cast<std::ptrdiff_t>(c.read_from), length, buffer);
    c.read_from += length;
    if (c.read_from == c.readable.size()) {
        c.readable.clear();
        c.read_from = 0;
    }
    if (length == 0 && c.leaving && c.due.empty()) {
        c = Client{};
        return -1;
    }
    return static_cast<int>(length);
}

int Lockstep_link::write(std::uint32_t client, const std::uint8_t *bytes, std::size_t length) {
    Client &c = clients_.at(client);
    if (!c.connected) {
        return -1;
    }
    if (c.leaving) {
        return static_cast<int>(length); // as a socket takes what nobody will read
    }
    if (c.outgoing.size() + length > most_waiting_bytes) {
        return 0;
    }
    c.outgoing.insert(c.outgoing.end(), bytes, bytes + length);
    return static_cast<int>(length);
}

void Lockstep_link::close(std::uint32_t client) {
    flush(clients_.at(client));
    hang_up(clients_.at(client));
    clients_.at(client) = Client{};
}

void Lockstep_link::frame_sent(std::uint32_t client, std::uint32_t sequence, std::int64_t now_ns) {
    Client &c = clients_.at(client);
    if (sequence != 0 && c.driver && !paced_) {
        c.unanswered.push_back({sequence, now_ns});
    }
}

void Lockstep_link::silence_host() {
    silenced_ = true;
}

std::int64_t Lockstep_link::barrier_ns() const {
    for (const Client &client : clients_) {
        if (client.driver && !client.leaving && !silenced_ && !paced_) {
            for (const Sent &sent : client.unanswered) {
                if (sent.sequence > client.idle) {
                    return sent.time_ns + answer_ns;
                }
            }
        }
    }
    return INT64_MAX;
}

std::int64_t Lockstep_link::next_delivery_ns() const {
    std::int64_t earliest = INT64_MAX;
    for (const Client &client : clients_) {
        if (!client.due.empty()) {
            earliest = std::min(earliest, client.due.front().time_ns);
        }
    }
    return earliest;
}

bool Lockstep_link::deliver(std::int64_t now_ns) {
    bool delivered = false;
    for (Client &client : clients_) {
        while (!client.due.empty() && client.due.front().time_ns <= now_ns) {
            const std::vector<std::uint8_t> &bytes = client.due.front().bytes;
            client.readable.insert(client.readable.end(), bytes.begin(), bytes.end());
            client.due.pop_front();
            delivered = true;
        }
    }
    return delivered;
}

bool Lockstep_link::exchange(std::int64_t now_ns, std::int64_t timeout_ns) {
    std::array<pollfd, 1 + GN_LINK_CLIENTS> polled{};
    polled.at(0) = {listener_, POLLIN, 0};
    for (std::size_t i = 0; i < clients_.size(); ++i) {
        flush(clients_.at(i));
        const Client &c = clients_.at(i);
        bool const talks = c.connected && !c.leaving;
        auto const events = static_cast<short>(c.outgoing.empty() ? POLLIN : POLLIN | POLLOUT);
        polled.at(1 + i) = {talks ? c.socket : -1, events, 0};
    }
    timespec timeout{};
    timeout.tv_sec = timeout_ns / 1000000000;
    timeout.tv_nsec = timeout_ns % 1000000000;
    if (ppoll(polled.data(), polled.size(), timeout_ns < 0 ? nullptr : &timeout, nullptr) <= 0) {
        return false;
    }
    bool changed = false;
    for (std::size_t i = 0; i < clients_.size(); ++i) {
        if ((polled.at(1 + i).revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
            changed = receive(clients_.at(i), now_ns) || changed;
        }
    }
    if ((polled.at(0).revents & POLLIN) != 0) {
        accept_clients();
        changed = true;
    }
    ++round_trips_;
    return changed;
}

bool Lockstep_link::driver_present() const {
    return std::any_of(clients_.begin(), clients_.end(),
                       [this](const Client &c) { return c.driver && !c.leaving && !silenced_; });
}

bool Lockstep_link::any_client() const {
    return std::any_of(clients_.begin(), clients_.end(), [](const Client &c) { return c.connected; });
}

std::string Lockstep_link::waited_for() const {
    for (const Client &c : clients_) {
        if (c.driver && !c.unanswered.empty()) {
            return "the driver at " + c.name + ", which has not said IDLE for frame " +
                   std::to_string(c.unanswered.back().sequence) + " (last: " + std::to_string(c.idle) + ")";
        }
        if (c.connected && !c.greeted) {
            return "the client at " + c.name + ", which has not said HELLO";
        }
    }
    return "a driver, to connect to " + address() + " and say HELLO";
}

void Lockstep_link::accept_clients() {
    for (Client &client : clients_) {
        if (client.connected) {
            continue;
        }
        int const socket = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (socket < 0) {
            return;
        }
        int const on = 1;
        setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        client = Client{};
        client.socket = socket;
        client.connected = true;
        client.name = text_of(address_of(socket, true));
        return;
    }
    // Both places are taken: whoever comes now is turned away.
    int const socket = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket >= 0) {
        ::close(socket);
    }
}

// true: something for the firmware, sooner or later.
bool Lockstep_link::receive(Client &client, std::int64_t now_ns) {
    ssize_t const length = recv(client.socket, chunk_.data(), chunk_.size(), 0);
    if (length < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) {
        return false;
    }
    if (length <= 0) {
        hang_up(client);
        client.leaving = true;
        return true;
    }
    if (client.driver && silenced_) {
        return false;
    }
    client.incoming.insert(client.incoming.end(), chunk_.begin(), chunk_.begin() + length);
    sort_frames(client, now_ns);
    return true;
}

void Lockstep_link::sort_frames(Client &client, std::int64_t now_ns) {
    std::size_t taken = 0;
    const std::vector<std::uint8_t> &bytes = client.incoming;
    while (bytes.size() - taken >= sizeof(gn_frame_header)) {
        gn_frame_header header{};
        std::memcpy(&header, bytes.data() + taken, sizeof header);
        std::size_t size = frame_size(bytes.data() + taken, bytes.size() - taken);
        if (header.magic != magic || header.length > UINT16_MAX + 1U) {
            size = bytes.size() - taken; // the firmware shall see it and refuse it
        }
        if (size > bytes.size() - taken) {
            break;
        }
        take_frame(client, bytes.data() + taken, size, now_ns);
        taken += size;
    }
    client.incoming.erase(client.incoming.begin(), client.incoming.begin() + static_cast<std::ptrdiff_t>(taken));
}

void Lockstep_link::take_frame(Client &client, const std::uint8_t *frame, std::size_t size, std::int64_t now_ns) {
    gn_frame_header header{};
    std::memcpy(&header, frame, sizeof header);
    if (!client.greeted && header.kind == GN_FRAME_HELLO) {
        client.greeted = true;
        served_ = true;
        client.driver = says_driver(frame + sizeof header, size - sizeof header);
    }
    std::int64_t time_ns = now_ns;
    if (client.driver && !paced_) {
        while (!client.unanswered.empty() && client.unanswered.front().sequence < header.acknowledged) {
            client.unanswered.pop_front();
        }
        if (!client.unanswered.empty() && client.unanswered.front().sequence == header.acknowledged) {
            time_ns = std::max(now_ns, client.unanswered.front().time_ns + answer_ns);
        }
        if (header.kind == GN_FRAME_IDLE) {
            client.idle = std::max(client.idle, header.acknowledged);
        }
        if (!client.due.empty()) {
            time_ns = std::max(time_ns, client.due.back().time_ns);
        }
    }
    client.due.push_back({time_ns, std::vector<std::uint8_t>(frame, frame + size)});
}

void Lockstep_link::flush(Client &client) {
    if (client.socket < 0 || client.outgoing.empty()) {
        return;
    }
    ssize_t const length = send(client.socket, client.outgoing.data(), client.outgoing.size(), MSG_NOSIGNAL);
    if (length > 0) {
        client.outgoing.erase(client.outgoing.begin(), client.outgoing.begin() + length);
    }
}

void Lockstep_link::hang_up(Client &client) {
    if (client.socket >= 0) {
        ::close(client.socket);
        client.socket = -1;
    }
    client.outgoing.clear();
}

} // namespace gonio::sim
