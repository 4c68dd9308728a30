// interlocks.hpp: door, emergency stop, STO and limit line in hardware, and the shutter that a spring closes.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>

#include "edge.h"
#include "scheduler.hpp"

namespace gonio::sim {

// The safety chain: a pressed emergency stop, an open door or an open STO line takes the torque from the drives.
class Interlocks {
public:
    using Line_changed = std::function<void(std::uint32_t line, bool level)>;
    using Torque_changed = std::function<void(bool allowed)>;

    Interlocks(Line_changed line_changed, Torque_changed torque_changed)
        : line_changed_(std::move(line_changed)), torque_changed_(std::move(torque_changed)) {}

    void set_door(bool closed);
    void set_emergency_stop(bool released);
    // A fault of the line itself.
    void set_sto(bool released);
    // The line of the limit switches, which stops nothing by itself; the firmware does.
    void set_limit(bool free);
    [[nodiscard]] bool level(std::uint32_t line) const;
    [[nodiscard]] bool light_allowed() const { return door_closed_ && stop_released_; }
    [[nodiscard]] bool torque_allowed() const { return door_closed_ && stop_released_ && sto_released_; }

private:
    void apply(bool &input, bool value);

    Line_changed line_changed_;
    Torque_changed torque_changed_;
    bool door_closed_ = true;
    bool stop_released_ = true;
    bool sto_released_ = true;
    bool limit_free_ = true;
};

// Open only while commanded, allowed by the interlocks and kept alive by watchdog pulses.
class Shutter {
public:
    explicit Shutter(Scheduler &scheduler) : scheduler_(scheduler) {}

    void command(bool open);
    void allow(bool allowed);
    void pulse_watchdog();
    [[nodiscard]] bool is_open() const { return open_; }
    // Whether light passed at a time of the last seconds.
    [[nodiscard]] bool was_open(std::int64_t time_ns) const;
    [[nodiscard]] std::uint64_t watchdog_trips() const { return watchdog_trips_; }

private:
    void update();
    void check_watchdog();

    struct Move {
        std::int64_t time_ns;
        bool open;
    };
    Scheduler &scheduler_;
    bool commanded_ = false;
    bool allowed_ = true;
    bool alive_ = false;
    bool target_ = false;
    bool open_ = false;
    bool check_pending_ = false;
    std::int64_t last_pulse_ns_ = 0;
    std::uint32_t order_ = 0; // only the last order is carried out
    std::uint64_t watchdog_trips_ = 0;
    std::deque<Move> moves_;
};

} // namespace gonio::sim
