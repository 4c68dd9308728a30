// control.hpp: the control socket: one command per line, one JSON object per line back.
#pragma once

#include <filesystem>
#include <functional>
#include <list>
#include <string>

#include "event_loop.hpp"

namespace gonio::sim {

class Control_socket final : public Source {
public:
    // Carries out one command; its answer is one line.
    using Obey = std::function<std::string(const std::string &command)>;

    // Throws Input_error when the socket cannot be made.
    Control_socket(std::filesystem::path path, Obey obey);
    ~Control_socket() override;
    Control_socket(const Control_socket &) = delete;
    Control_socket &operator=(const Control_socket &) = delete;
    Control_socket(Control_socket &&) = delete;
    Control_socket &operator=(Control_socket &&) = delete;

    void wait_for(std::vector<pollfd> &descriptors) const override;
    void serve() override;

private:
    struct Client {
        int socket;
        std::string incoming;
    };
    bool receive(Client &client);

    std::filesystem::path path_;
    Obey obey_;
    int listener_;
    std::list<Client> clients_;
};

} // namespace gonio::sim
