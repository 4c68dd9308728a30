// can_bus.hpp: the simulated CAN bus: one frame at a time, lowest identifier first, with the bit times of the bit rate.
// In front of a real bus, which takes the time itself, frames take none.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
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

// What the fault injector may do to a frame that wins arbitration. Lost: nobody receives it, its sender neither.
// Delayed: its sender asks for the bus again, delay_ns later (a frame is judged once).
enum class Frame_fate { deliver, lose, delay };

class Can_bus {
public:
    using Judge = std::function<Frame_fate(const gn_can_frame &frame, std::int64_t now_ns, std::int64_t &delay_ns)>;

    static constexpr std::uint32_t no_bit_times = 0; // in place of a bit rate

    Can_bus(Scheduler &scheduler, std::uint32_t bits_per_s) : scheduler_(scheduler), bits_per_s_(bits_per_s) {}
    // The node's index; it must outlive the bus.
    int attach(Can_node &node);
    // Queue a frame for arbitration. Frames queued at the same instant on a free bus take part in one arbitration.
    void send(int node, const gn_can_frame &frame);
    // A frame that a real bus carried already, heard by `node` at frame.stamp_ns: the others get it now with that
    // stamp.
    void hear(int node, const gn_can_frame &frame);
    void set_judge(Judge judge) { judge_ = std::move(judge); }
    // Frames that went over the wire.
    [[nodiscard]] std::uint64_t frames() const { return frames_; }
    // Bit times in use so far; over the time passed it is the bus load.
    [[nodiscard]] std::uint64_t busy_bits() const { return busy_bits_; }

private:
    struct Pending {
        gn_can_frame frame;
        std::uint64_t order;
        int node;
        bool judged;
    };
    void queue(const Pending &pending);
    void deliver(int sender, gn_can_frame frame, bool echo);
    void arbitrate();
    void finish();
    [[nodiscard]] std::int64_t bit_times_ns(std::uint64_t bits) const;

    Scheduler &scheduler_;
    std::uint32_t bits_per_s_;
    std::vector<Can_node *> nodes_;
    std::vector<Pending> waiting_; // the next winner is at the end
    Pending on_wire_{};
    bool lost_ = false;
    bool busy_ = false; // a frame is on the wire or an arbitration is due
    std::uint64_t order_ = 0;
    std::uint64_t frames_ = 0;
    std::uint64_t busy_bits_ = 0;
    Judge judge_;
};

} // namespace gonio::sim
