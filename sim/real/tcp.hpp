// tcp.hpp: loopback addresses and listening sockets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace gonio::sim {

// "127.0.0.1:PORT" taken apart. Throws Input_error; `option` is what the user wrote it for.
std::pair<std::string, std::uint16_t> parse_address(const std::string &option, const std::string &address);

// A listening socket that does not block. Throws Input_error.
int listen_tcp(const std::string &option, const std::string &host, std::uint16_t port);
// A connected socket. Throws Input_error.
int connect_tcp(const std::string &option, const std::string &host, std::uint16_t port);
// Appends what has come over a socket that does not block, and lets `take` remove whole commands from it, until nothing
// more is there. false: the other side is gone, `take` has had enough, or `longest` bytes hold no command.
bool receive_commands(int socket, std::string &incoming, std::size_t longest, const std::function<bool()> &take);
// The local port of a socket.
std::uint16_t tcp_port(int socket);

} // namespace gonio::sim
