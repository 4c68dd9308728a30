// can_bus.cpp: arbitration, bit times and delivery of the simulated CAN bus.
#include "can_bus.hpp"

#include <algorithm>

#include "can_bits.hpp"

namespace gonio::sim {

int Can_bus::attach(Can_node &node) {
    nodes_.push_back(&node);
    return static_cast<int>(nodes_.size()) - 1;
}

std::int64_t Can_bus::bit_times_ns(std::uint64_t bits) const {
    return bits_per_s_ == no_bit_times ? 0 : static_cast<std::int64_t>(bits * 1'000'000'000U / bits_per_s_);
}

void Can_bus::send(int node, const gn_can_frame &frame) {
    Pending pending{frame, order_++, node, false};
    pending.frame.own_echo = false;
    queue(pending);
}

void Can_bus::queue(const Pending &pending) {
    // Highest identifier first, so that the winner is taken from the end; few frames ever wait.
    const auto wins_later = [](const Pending &a, const Pending &b) {
        return a.frame.id != b.frame.id ? a.frame.id > b.frame.id : a.order > b.order;
    };
    waiting_.insert(std::upper_bound(waiting_.begin(), waiting_.end(), pending, wins_later), pending);
    if (!busy_) {
        busy_ = true;
        scheduler_.after(0, [this] { arbitrate(); });
    }
}

void Can_bus::arbitrate() {
    while (!waiting_.empty()) {
        on_wire_ = waiting_.back();
        waiting_.pop_back();
        lost_ = false;
        if (judge_ && !on_wire_.judged) {
            std::int64_t delay_ns = 0;
            const Frame_fate fate = judge_(on_wire_.frame, scheduler_.now_ns(), delay_ns);
            on_wire_.judged = true;
            if (fate == Frame_fate::delay) {
                scheduler_.after(delay_ns, [this, held = on_wire_] { queue(held); });
                continue;
            }
            lost_ = fate == Frame_fate::lose;
        }
        const unsigned bits = can_frame_bits(on_wire_.frame);
        busy_bits_ += bits + can_intermission_bits;
        scheduler_.after(bit_times_ns(bits), [this] { finish(); });
        return;
    }
    busy_ = false;
}

void Can_bus::finish() {
    ++frames_;
    // Before delivery: what the receivers send at once takes part in the next arbitration.
    scheduler_.after(bit_times_ns(can_intermission_bits), [this] { arbitrate(); });
    if (lost_) {
        return;
    }
    gn_can_frame frame = on_wire_.frame;
    frame.stamp_ns = scheduler_.now_ns();
    deliver(on_wire_.node, frame, true);
}

void Can_bus::hear(int node, const gn_can_frame &frame) {
    std::int64_t delay_ns = 0;
    const Frame_fate fate = judge_ ? judge_(frame, scheduler_.now_ns(), delay_ns) : Frame_fate::deliver;
    ++frames_;
    if (fate == Frame_fate::delay) {
        scheduler_.after(delay_ns, [this, node, frame] { deliver(node, frame, false); });
    } else if (fate == Frame_fate::deliver) {
        deliver(node, frame, false);
    }
}

void Can_bus::deliver(int sender, gn_can_frame frame, bool echo) {
    for (int node = 0; node < static_cast<int>(nodes_.size()); ++node) {
        frame.own_echo = node == sender;
        if (node != sender || echo) {
            nodes_[static_cast<std::size_t>(node)]->on_frame(frame);
        }
    }
}

} // namespace gonio::sim
