// socketcand.hpp: a server of the socketcand protocol in raw mode: any python-can program (interface "socketcand")
// talks to the simulated drives, with no CAN hardware and no CAN in the kernel.
#pragma once

#include <cstdint>
#include <list>
#include <string>

#include "can_wire.hpp"

namespace gonio::sim {

class Socketcand final : public Can_wire {
public:
    // Listens at once. Throws Input_error when the address cannot be had.
    Socketcand(Scheduler &scheduler, const std::string &host, std::uint16_t port);
    ~Socketcand() override;
    Socketcand(const Socketcand &) = delete;
    Socketcand &operator=(const Socketcand &) = delete;
    Socketcand(Socketcand &&) = delete;
    Socketcand &operator=(Socketcand &&) = delete;

    [[nodiscard]] std::uint16_t port() const;

    void wait_for(std::vector<pollfd> &descriptors) const override;
    void serve() override;
    void send(const gn_can_frame &frame) override;
    [[nodiscard]] std::uint64_t frames_dropped() const override { return dropped_; }

private:
    struct Client {
        int socket;
        std::string incoming;
        std::string outgoing;
        bool raw = false;                // it wants frames
        std::int64_t frames_from_ns = 0; // a client reads the answer to "rawmode" as all that there is
    };
    void accept_clients();
    bool receive(Client &client);
    void obey(Client &client, const std::string &command);
    void tell(const Client *except, const gn_can_frame &frame);
    static bool flush(Client &client);

    Scheduler &scheduler_;
    int listener_;
    std::list<Client> clients_;
    std::uint64_t dropped_ = 0;
};

} // namespace gonio::sim
