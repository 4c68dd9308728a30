// event_loop.cpp: one turn: wait, serve, live up to the present.
#include "event_loop.hpp"

#include <algorithm>
#include <ctime>

#include <sys/prctl.h>

namespace gonio::sim {
namespace {

constexpr std::int64_t second_ns = 1000000000;
constexpr std::int64_t longest_wait_ns = 100000000; // a signal is noticed at the latest after this

} // namespace

std::int64_t monotonic_ns() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * second_ns + now.tv_nsec;
}

void Event_loop::run(const std::atomic<bool> &ended) {
    prctl(PR_SET_TIMERSLACK, 1UL); // ns; the default of 50 us would be the strobe's jitter
    while (!ended) {
        turn(longest_wait_ns);
    }
}

void Event_loop::turn(std::int64_t longest_ns) {
    descriptors_.clear();
    ends_.clear();
    for (const Source *source : sources_) {
        source->wait_for(descriptors_);
        ends_.push_back(descriptors_.size());
    }
    std::int64_t const wait_ns =
        std::clamp<std::int64_t>(scheduler_.next_ns() - monotonic_ns(), 0, std::max<std::int64_t>(longest_ns, 0));
    timespec const timeout{wait_ns / second_ns, wait_ns % second_ns};
    ppoll(descriptors_.data(), descriptors_.size(), &timeout, nullptr);
    std::int64_t const now_ns = monotonic_ns();
    std::size_t first = 0;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        bool woken = false;
        for (; first < ends_.at(i); ++first) {
            woken = woken || descriptors_.at(first).revents != 0;
        }
        if (woken || sources_.at(i)->stamped()) {
            sources_.at(i)->serve();
        }
    }
    while (scheduler_.run_one(now_ns)) {
    }
    if (on_turn) {
        on_turn();
    }
}

} // namespace gonio::sim
