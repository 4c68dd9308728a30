// tcp.hpp: loopback addresses and listening sockets.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace gonio::sim {

// "127.0.0.1:PORT" taken apart. Throws Input_error; `option` is what the user wrote it for.
std::pair<std::string, std::uint16_t> parse_address(const std::string &option, const std::string &address);

// A listening socket that does not block. Throws Input_error.
int listen_tcp(const std::string &option, const std::string &host, std::uint16_t port);
// A connected socket. Throws Input_error.
int connect_tcp(const std::string &option, const std::string &host, std::uint16_t port);
// The local port of a socket.
std::uint16_t tcp_port(int socket);

} // namespace gonio::sim
