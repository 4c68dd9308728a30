// lockstep_link.hpp: the link over loopback TCP: one driver that keeps step with virtual time (protocol/link.md), and
// visitors.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "carrier.hpp"
#include "link.h"

namespace gonio::sim {

class Lockstep_link final : public Carrier {
public:
    // Listens at once. paced: real time, nobody is waited for. Throws Input_error when the address cannot be had.
    Lockstep_link(const std::string &host, std::uint16_t port, bool paced);
    ~Lockstep_link() override;
    Lockstep_link(const Lockstep_link &) = delete;
    Lockstep_link &operator=(const Lockstep_link &) = delete;
    Lockstep_link(Lockstep_link &&) = delete;
    Lockstep_link &operator=(Lockstep_link &&) = delete;

    [[nodiscard]] std::string address() const;

    int read(std::uint32_t client, std::uint8_t *buffer, std::size_t capacity) override;
    int write(std::uint32_t client, const std::uint8_t *bytes, std::size_t length) override;
    void close(std::uint32_t client) override;
    void frame_sent(std::uint32_t client, std::uint32_t sequence, std::int64_t now_ns) override;
    void silence_host() override;

    // Virtual time must not pass this before the driver has said IDLE; INT64_MAX: it is free.
    [[nodiscard]] std::int64_t barrier_ns() const;
    // When the next host frame is due; INT64_MAX: none waits.
    [[nodiscard]] std::int64_t next_delivery_ns() const;
    // Hands what is due at now_ns to the firmware's read; false: nothing was.
    bool deliver(std::int64_t now_ns);
    // Sends what waits, then accepts and reads what comes within timeout_ns (negative: without limit). false: nothing
    // came. true: something can be read, or a client came or went.
    bool exchange(std::int64_t now_ns, std::int64_t timeout_ns);

    [[nodiscard]] bool driver_present() const;
    [[nodiscard]] bool any_client() const;
    [[nodiscard]] bool ever_served() const { return served_; }
    [[nodiscard]] std::uint64_t round_trips() const { return round_trips_; }
    // Who is waited for, and for what.
    [[nodiscard]] std::string waited_for() const;

private:
    struct Sent {
        std::uint32_t sequence;
        std::int64_t time_ns;
    };
    struct Delivery {
        std::int64_t time_ns;
        std::vector<std::uint8_t> bytes;
    };
    struct Client {
        int socket = -1;
        bool connected = false; // the firmware may read and write
        bool greeted = false;
        bool driver = false;
        bool leaving = false; // its socket is shut; gone once the firmware has read the rest
        std::string name;
        std::vector<std::uint8_t> incoming; // not yet whole frames
        std::deque<Delivery> due;           // whole frames and when the firmware gets them
        std::vector<std::uint8_t> readable;
        std::size_t read_from = 0;
        std::vector<std::uint8_t> outgoing;
        std::deque<Sent> unanswered; // numbered frames that the driver may still answer
        std::uint32_t idle = 0;      // it has said IDLE up to this frame
    };

    void accept_clients();
    bool receive(Client &client, std::int64_t now_ns);
    void sort_frames(Client &client, std::int64_t now_ns);
    void take_frame(Client &client, const std::uint8_t *frame, std::size_t size, std::int64_t now_ns);
    void flush(Client &client);
    void hang_up(Client &client);

    int listener_ = -1;
    bool paced_;
    bool silenced_ = false;
    bool served_ = false;
    std::uint64_t round_trips_ = 0;
    std::array<Client, GN_LINK_CLIENTS> clients_;
    std::vector<std::uint8_t> chunk_;
};

} // namespace gonio::sim
