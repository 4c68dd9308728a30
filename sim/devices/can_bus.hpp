// can_bus.hpp: the simulated CAN bus: one frame at a time, lowest identifier first, with the bit times of the bit rate.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "can.h"
#include "scheduler.hpp"

namespace gonio::sim {

class Can_node {
public:
    virtual ~Can_node() = default;
    // A frame is complete on the bus (frame.stamp_ns = now); own_echo is set for the sender.
    virtual void on_frame(const gn_can_frame &frame) = 0;
};

// What the fault injector may do to a frame that wins arbitration.
enum class Frame_fate { deliver, lose, delay };

class Can_bus {
public:
    using Judge = std::function<Frame_fate(const gn_can_frame &frame, std::int64_t now_ns, std::int64_t &delay_ns)>;

    Can_bus(Scheduler &scheduler, std::uint32_t bits_per_s) : scheduler_(scheduler), bits_per_s_(bits_per_s) {}
    // The node's index; it must outlive the bus.
    int attach(Can_node &node);
    // Queue a frame for arbitration.
    void send(int node, const gn_can_frame &frame);
    void set_judge(Judge judge) { judge_ = std::move(judge); }
    [[nodiscard]] std::uint64_t frames() const { return frames_; }

private:
    void start_next();
    void deliver(int sender, gn_can_frame frame);

    struct Pending {
        int node;
        gn_can_frame frame;
    };
    Scheduler &scheduler_;
    std::uint32_t bits_per_s_;
    std::vector<Can_node *> nodes_;
    std::map<std::pair<std::uint32_t, std::uint64_t>, Pending> waiting_;  // by identifier, then order
    std::uint64_t order_ = 0;
    std::uint64_t frames_ = 0;
    bool busy_ = false;
    Judge judge_;
};

}  // namespace gonio::sim
