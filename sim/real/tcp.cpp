// tcp.cpp: sockets on the loopback interface.
#include "tcp.hpp"

#include <array>
#include <cerrno>
#include <cstring>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "toml_table.hpp"

namespace gonio::sim {
namespace {

sockaddr_in socket_address(const std::string &option, const std::string &host, std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    if (inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1) {
        throw Input_error(option + ": '" + host + "' is no address; write 127.0.0.1:PORT");
    }
    return address;
}

} // namespace

std::pair<std::string, std::uint16_t> parse_address(const std::string &option, const std::string &address) {
    auto const colon = address.rfind(':');
    std::string const port = colon == std::string::npos ? "" : address.substr(colon + 1);
    bool const digits = !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string::npos;
    unsigned long const number = digits ? std::stoul(port) : 65536;
    if (number > 65535) {
        throw Input_error(option + ": '" + address + "' is no address; write 127.0.0.1:PORT, PORT from 0 to 65535");
    }
    return {address.substr(0, colon), static_cast<std::uint16_t>(number)};
}

int listen_tcp(const std::string &option, const std::string &host, std::uint16_t port) {
    sockaddr_in const address = socket_address(option, host, port);
    int const listener = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    int const on = 1;
    setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(listener, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0 || listen(listener, 4) != 0) {
        std::string const why = std::strerror(errno);
        close(listener);
        throw Input_error(option + " " + host + ":" + std::to_string(port) + ": cannot listen there (" + why +
                          "); use another port, or 0 for any");
    }
    return listener;
}

int connect_tcp(const std::string &option, const std::string &host, std::uint16_t port) {
    sockaddr_in const address = socket_address(option, host, port);
    int const connection = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(connection, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0) {
        std::string const why = std::strerror(errno);
        close(connection);
        throw Input_error(option + " " + host + ":" + std::to_string(port) + ": nobody answers (" + why +
                          "); start the firmware first");
    }
    int const on = 1;
    setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return connection;
}

bool receive_commands(int socket, std::string &incoming, std::size_t longest, const std::function<bool()> &take) {
    std::array<char, 4096> chunk{};
    for (;;) {
        ssize_t const length = recv(socket, chunk.data(), chunk.size(), 0);
        if (length < 0) {
            return errno == EAGAIN || errno == EINTR;
        }
        if (length == 0) {
            return false;
        }
        incoming.append(chunk.data(), static_cast<std::size_t>(length));
        if (!take() || incoming.size() > longest) {
            return false;
        }
    }
}

std::uint16_t tcp_port(int socket) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (getsockname(socket, reinterpret_cast<sockaddr *>(&address), &size) != 0) {
        return 0;
    }
    return ntohs(address.sin_port);
}

} // namespace gonio::sim
