// scheduler.hpp: virtual time. Events run in order of time, then of being scheduled, so a run repeats bit for bit.
#pragma once

#include <cstdint>
#include <functional>
#include <queue>
#include <vector>

namespace gonio::sim {

class Scheduler {
public:
    using Action = std::function<void()>;

    [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }

    // Times in the past are taken as now.
    void at(std::int64_t time_ns, Action action) {
        queue_.push(Event{time_ns < now_ns_ ? now_ns_ : time_ns, next_number_++, std::move(action)});
    }
    void after(std::int64_t delay_ns, Action action) { at(now_ns_ + delay_ns, std::move(action)); }

    // Time of the next event, or INT64_MAX.
    [[nodiscard]] std::int64_t next_ns() const { return queue_.empty() ? INT64_MAX : queue_.top().time_ns; }

    // Run the next event; false if there is none at or before limit_ns (time then stands at limit_ns).
    bool run_one(std::int64_t limit_ns) {
        if (next_ns() > limit_ns) {
            now_ns_ = limit_ns > now_ns_ ? limit_ns : now_ns_;
            return false;
        }
        Action action = std::move(const_cast<Event &>(queue_.top()).action);
        now_ns_ = queue_.top().time_ns;
        queue_.pop();
        action();
        return true;
    }

private:
    struct Event {
        std::int64_t time_ns;
        std::uint64_t number;
        Action action;
        bool operator<(const Event &other) const {
            return time_ns != other.time_ns ? time_ns > other.time_ns : number > other.number;
        }
    };
    std::priority_queue<Event> queue_;
    std::int64_t now_ns_ = 0;
    std::uint64_t next_number_ = 0;
};

}  // namespace gonio::sim
