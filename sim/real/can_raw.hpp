// can_raw.hpp: the simulated drives on a SocketCAN interface.
#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "can_wire.hpp"

namespace gonio::sim {

class Can_raw final : public Can_wire {
public:
    // Throws Input_error when there is no such interface.
    Can_raw(Scheduler &scheduler, const std::string &interface);
    // For tests: a descriptor that carries struct can_frame, one a message; it becomes this object's.
    Can_raw(Scheduler &scheduler, int descriptor);
    ~Can_raw() override;
    Can_raw(const Can_raw &) = delete;
    Can_raw &operator=(const Can_raw &) = delete;
    Can_raw(Can_raw &&) = delete;
    Can_raw &operator=(Can_raw &&) = delete;

    void wait_for(std::vector<pollfd> &descriptors) const override;
    void serve() override;
    void send(const gn_can_frame &frame) override;
    [[nodiscard]] std::uint64_t frames_dropped() const override { return dropped_; }

private:
    enum class Sent { yes, later, never };
    [[nodiscard]] Sent write_frame(const gn_can_frame &frame) const;
    void empty_queue();

    Scheduler &scheduler_;
    int socket_;
    std::deque<gn_can_frame> queue_; // while the interface takes no more
    bool retry_due_ = false;
    std::uint64_t dropped_ = 0;
};

} // namespace gonio::sim
