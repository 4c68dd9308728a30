// scheduler.hpp: the twin's time. Events run in order of time, then of being scheduled, so that in virtual time a run
// repeats bit for bit.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace gonio::sim {

class Scheduler {
public:
    // A closure of up to 16 bytes (this and one more word) costs no allocation.
    using Action = std::function<void()>;

    // Virtual time begins at 0; in real time the scheduler's time is CLOCK_MONOTONIC.
    explicit Scheduler(std::int64_t start_ns = 0) : now_ns_(start_ns) {}

    [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }

    // Times in the past are taken as now.
    void at(std::int64_t time_ns, Action action) {
        std::uint32_t slot = 0;
        if (free_.empty()) {
            slot = static_cast<std::uint32_t>(actions_.size());
            actions_.push_back(std::move(action));
        } else {
            slot = free_.back();
            free_.pop_back();
            actions_[slot] = std::move(action);
        }
        heap_.push_back(Event{std::max(time_ns, now_ns_), next_number_++, slot});
        std::push_heap(heap_.begin(), heap_.end(), later);
    }
    void after(std::int64_t delay_ns, Action action) { at(now_ns_ + delay_ns, std::move(action)); }

    // Time of the next event, or INT64_MAX.
    [[nodiscard]] std::int64_t next_ns() const { return heap_.empty() ? INT64_MAX : heap_.front().time_ns; }

    // Run the next event; false if there is none at or before limit_ns (time then stands at limit_ns).
    bool run_one(std::int64_t limit_ns) {
        if (next_ns() > limit_ns) {
            now_ns_ = std::max(limit_ns, now_ns_);
            return false;
        }
        std::pop_heap(heap_.begin(), heap_.end(), later);
        const Event event = heap_.back();
        heap_.pop_back();
        now_ns_ = event.time_ns;
        const Action action = std::move(actions_[event.slot]);
        free_.push_back(event.slot);
        action();
        return true;
    }

private:
    // The heap moves these small records only; the closures stay in their slots.
    struct Event {
        std::int64_t time_ns;
        std::uint64_t number;
        std::uint32_t slot;
    };
    static bool later(const Event &a, const Event &b) {
        return a.time_ns != b.time_ns ? a.time_ns > b.time_ns : a.number > b.number;
    }

    std::vector<Event> heap_;
    std::vector<Action> actions_;
    std::vector<std::uint32_t> free_;
    std::int64_t now_ns_;
    std::uint64_t next_number_ = 0;
};

} // namespace gonio::sim
