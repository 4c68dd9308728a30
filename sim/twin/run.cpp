// run.cpp: who waits for whom.
#include "run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace gonio::sim {
namespace {

constexpr std::int64_t look_every_ns =
    100000000; // virtual time between looks at the sockets when no driver holds the clock
constexpr std::int64_t rest_limit_ns = 30000000000; // virtual time in which the instrument must come to rest
constexpr std::int64_t wait_step_ns = 500000000;    // wall time; a signal is noticed at the latest after this
constexpr std::int64_t pace_step_ns = 500000;       // wall time; shorter sleeps cost more than they give

std::int64_t wall_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

// Waits on the sockets until something comes.
void wait_for_clients(World &world, Lockstep_link &link, double patience_s, const std::atomic<bool> &ended) {
    std::int64_t const end_ns = wall_ns() + std::llround(patience_s * 1e9);
    while (!ended) {
        std::int64_t const left_ns = end_ns - wall_ns();
        if (left_ns <= 0) {
            throw Stalled("no progress for " + std::to_string(std::lround(patience_s)) + " s: waiting for " +
                          link.waited_for());
        }
        if (link.exchange(world.scheduler().now_ns(), std::min(left_ns, wait_step_ns))) {
            return;
        }
    }
}

// Runs on until the time of the next delivery, or the time that may not be passed, or the driver falls silent.
void advance(World &world, Lockstep_link &link) {
    while (link.driver_present() && world.scheduler().run_one(std::min(link.barrier_ns(), link.next_delivery_ns()))) {
    }
}

} // namespace

std::string run_virtual(World &world, Lockstep_link &link, double patience_s, const std::atomic<bool> &ended) {
    bool had_driver = false;
    std::int64_t alone_since_ns = 0;
    while (!ended) {
        std::int64_t const now_ns = world.scheduler().now_ns();
        if (link.driver_present()) {
            had_driver = true;
            advance(world, link);
            // What is due now is handed over when all of it is known.
            if (link.barrier_ns() <= world.scheduler().now_ns()) {
                wait_for_clients(world, link, patience_s, ended);
            } else if (link.deliver(world.scheduler().now_ns())) {
                world.link_changed();
            }
            continue;
        }
        if (had_driver) {
            had_driver = false;
            alone_since_ns = now_ns;
            if (!world.standstill().watching) {
                world.host_lost();
            }
        }
        bool const changed = link.deliver(INT64_MAX);
        world.link_changed();
        bool const alone = link.ever_served() && (alone_since_ns > 0 || !link.any_client());
        if (alone && world.at_rest() && world.dark()) {
            return world.standstill().watching ? "driver gone, at rest and dark" : "client gone";
        }
        if (alone) {
            if (now_ns - alone_since_ns > rest_limit_ns) {
                return "not at rest and dark after " + std::to_string(rest_limit_ns / 1000000000) + " s";
            }
            while (world.scheduler().run_one(now_ns + look_every_ns)) {
            }
            link.exchange(world.scheduler().now_ns(), 0);
        } else if (!changed) {
            // Before a driver's HELLO virtual time stands still.
            wait_for_clients(world, link, patience_s, ended);
        }
    }
    return "ended by a signal";
}

std::string run_paced(World &world, Lockstep_link &link, const std::atomic<bool> &ended) {
    std::int64_t start_ns = wall_ns() - world.scheduler().now_ns();
    std::int64_t held_ns = world.apparatus().optics().held_ns();
    bool had_driver = false;
    while (!ended) {
        std::int64_t const target_ns = wall_ns() - start_ns;
        while (world.scheduler().run_one(target_ns)) {
        }
        // The clock stood while light was traced: made up for, the firmware would take it for a host that is silent.
        std::int64_t const held_before_ns = std::exchange(held_ns, world.apparatus().optics().held_ns());
        start_ns += held_ns - held_before_ns;
        std::int64_t const until_next_ns = world.scheduler().next_ns() - (wall_ns() - start_ns);
        if (link.exchange(target_ns, std::clamp(until_next_ns, pace_step_ns, wait_step_ns))) {
            link.deliver(INT64_MAX);
            world.link_changed();
        }
        if (had_driver && !link.driver_present()) {
            world.host_lost();
        }
        had_driver = link.driver_present();
    }
    return "ended by a signal";
}

} // namespace gonio::sim
