// can_wire.hpp: a real CAN bus, or what passes for one, and the bridge that puts the simulated drives on it.
#pragma once

#include <functional>
#include <string>

#include "can_bus.hpp"
#include "event_loop.hpp"

namespace gonio::sim {

class Can_wire : public Source {
public:
    // stamp_ns of the frame: CLOCK_MONOTONIC, when it was on the bus.
    using Heard = std::function<void(const gn_can_frame &frame)>;

    virtual void send(const gn_can_frame &frame) = 0;
    [[nodiscard]] virtual std::uint64_t frames_dropped() const = 0;
    void on_frame(Heard heard) { heard_ = std::move(heard); }
    [[nodiscard]] bool stamped() const override { return true; }

protected:
    void hear(const gn_can_frame &frame) const { heard_(frame); }

private:
    Heard heard_;
};

// What the wire carries reaches the drives at its stamp or, if that is past, now; what a drive sends leaves at once.
class Can_bridge final : public Can_node {
public:
    Can_bridge(Scheduler &scheduler, Can_bus &bus, Can_wire &wire) : wire_(wire), node_(bus.attach(*this)) {
        wire.on_frame([this, &scheduler, &bus](const gn_can_frame &frame) {
            while (scheduler.run_one(frame.stamp_ns)) {
            }
            bus.hear(node_, frame);
        });
    }
    void on_frame(const gn_can_frame &frame) override { wire_.send(frame); }

private:
    Can_wire &wire_;
    int node_;
};

} // namespace gonio::sim
