// event_loop.hpp: real time: waits for whatever comes first, the scheduler's next event or something at a descriptor.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include <poll.h>

#include "scheduler.hpp"

namespace gonio::sim {

// CLOCK_MONOTONIC, the scheduler's time.
std::int64_t monotonic_ns();

// Something with descriptors of its own.
class Source {
public:
    virtual ~Source() = default;
    virtual void wait_for(std::vector<pollfd> &descriptors) const = 0;
    // Takes what is there, without waiting; nothing may be.
    virtual void serve() = 0;
    // What it brings carries stamps: it is served every turn, also when it woke nobody.
    [[nodiscard]] virtual bool stamped() const { return false; }
};

class Event_loop {
public:
    explicit Event_loop(Scheduler &scheduler) : scheduler_(scheduler) {}
    // Served in this order; each must outlive the loop.
    void add(Source &source) { sources_.push_back(&source); }
    // After every turn.
    std::function<void()> on_turn;
    // Until `ended`. What came from outside by a certain moment is served before the devices live through that moment,
    // so a twin that is late answers late but never forgets the order of things.
    void run(const std::atomic<bool> &ended);
    // One turn, waiting no longer than this.
    void turn(std::int64_t longest_ns);

private:
    Scheduler &scheduler_;
    std::vector<Source *> sources_;
    std::vector<pollfd> descriptors_;
    std::vector<std::size_t> ends_; // of each source's part of them
};

} // namespace gonio::sim
