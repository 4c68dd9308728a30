// interlocks.cpp: the safety chain's logic and the shutter's delays.
#include "interlocks.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t shutter_travel_ns = 20000000;
constexpr std::int64_t watchdog_ns = 100000000;
constexpr std::size_t moves_remembered = 16;

} // namespace

void Interlocks::set_door(bool closed) {
    apply(door_closed_, closed);
}

void Interlocks::set_emergency_stop(bool released) {
    apply(stop_released_, released);
}

void Interlocks::set_sto(bool released) {
    apply(sto_released_, released);
}

void Interlocks::set_limit(bool free) {
    apply(limit_free_, free);
}

bool Interlocks::level(std::uint32_t line) const {
    switch (line) {
    case GN_LINE_DOOR:
        return door_closed_;
    case GN_LINE_EMERGENCY_STOP:
        return stop_released_;
    case GN_LINE_STO:
        return torque_allowed();
    case GN_LINE_LIMIT:
        return limit_free_;
    default:
        return false;
    }
}

void Interlocks::apply(bool &input, bool value) {
    constexpr std::array lines = {GN_LINE_DOOR, GN_LINE_EMERGENCY_STOP, GN_LINE_STO, GN_LINE_LIMIT};
    std::array<bool, lines.size()> before{};
    for (std::size_t i = 0; i < lines.size(); ++i) {
        before.at(i) = level(lines.at(i));
    }
    bool const torque_before = torque_allowed();
    input = value;
    if (torque_allowed() != torque_before) {
        torque_changed_(torque_allowed());
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (level(lines.at(i)) != before.at(i)) {
            line_changed_(lines.at(i), level(lines.at(i)));
        }
    }
}

void Shutter::command(bool open) {
    commanded_ = open;
    update();
}

void Shutter::allow(bool allowed) {
    allowed_ = allowed;
    update();
}

void Shutter::pulse_watchdog() {
    last_pulse_ns_ = scheduler_.now_ns();
    if (!check_pending_) {
        check_pending_ = true;
        scheduler_.after(watchdog_ns, [this] { check_watchdog(); });
    }
    if (!alive_) {
        alive_ = true;
        update();
    }
}

bool Shutter::was_open(std::int64_t time_ns) const {
    bool open = open_;
    for (auto move = moves_.rbegin(); move != moves_.rend() && move->time_ns > time_ns; ++move) {
        open = !move->open;
    }
    return open;
}

void Shutter::update() {
    bool const target = commanded_ && allowed_ && alive_;
    if (target == target_) {
        return;
    }
    target_ = target;
    scheduler_.after(shutter_travel_ns, [this, order = ++order_] {
        if (order == order_ && open_ != target_) {
            open_ = target_;
            moves_.push_back({scheduler_.now_ns(), open_});
            if (moves_.size() > moves_remembered) {
                moves_.pop_front();
            }
        }
    });
}

void Shutter::check_watchdog() {
    std::int64_t const silent_ns = scheduler_.now_ns() - last_pulse_ns_;
    if (silent_ns < watchdog_ns) {
        scheduler_.after(watchdog_ns - silent_ns, [this] { check_watchdog(); });
        return;
    }
    check_pending_ = false;
    alive_ = false;
    watchdog_trips_ += commanded_ ? 1U : 0U;
    update();
}

} // namespace gonio::sim
