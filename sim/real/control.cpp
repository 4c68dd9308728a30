// control.cpp: lines in, lines out.
#include "control.hpp"

#include <cerrno>
#include <cstring>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tcp.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr std::size_t longest_command = 4096;

} // namespace

Control_socket::Control_socket(std::filesystem::path path, Obey obey)
    : path_(std::move(path)), obey_(std::move(obey)),
      listener_(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::string const text = path_.string();
    if (text.size() >= sizeof address.sun_path) {
        close(listener_);
        throw Input_error("--control " + text + ": too long for a socket; choose a shorter path");
    }
    std::memcpy(address.sun_path, text.c_str(), text.size());
    unlink(text.c_str()); // of an earlier run
    if (bind(listener_, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0 ||
        listen(listener_, 4) != 0) {
        std::string const why = std::strerror(errno);
        close(listener_);
        throw Input_error("--control " + text + ": no socket can be made there (" + why + "); choose another path");
    }
}

Control_socket::~Control_socket() {
    for (const Client &client : clients_) {
        close(client.socket);
    }
    close(listener_);
    unlink(path_.c_str());
}

void Control_socket::wait_for(std::vector<pollfd> &descriptors) const {
    descriptors.push_back({listener_, POLLIN, 0});
    for (const Client &client : clients_) {
        descriptors.push_back({client.socket, POLLIN, 0});
    }
}

void Control_socket::serve() {
    for (int socket = 0; (socket = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)) >= 0;) {
        clients_.push_back({socket, {}});
    }
    clients_.remove_if([this](Client &client) {
        bool const here = receive(client);
        if (!here) {
            close(client.socket);
        }
        return !here;
    });
}

bool Control_socket::receive(Client &client) {
    return receive_commands(client.socket, client.incoming, longest_command, [&] {
        std::size_t end = 0;
        while ((end = client.incoming.find('\n')) != std::string::npos) {
            std::string const answer = obey_(client.incoming.substr(0, end)) + "\n";
            client.incoming.erase(0, end + 1);
            // A few hundred bytes: whoever lets them pile up beyond the socket's buffer does not want them.
            if (send(client.socket, answer.data(), answer.size(), MSG_NOSIGNAL) !=
                static_cast<ssize_t>(answer.size())) {
                return false;
            }
        }
        return true;
    });
}

} // namespace gonio::sim
