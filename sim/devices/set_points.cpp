// set_points.cpp: interpolation of cyclic targets, and profile position.
#include "set_points.hpp"

#include <algorithm>
#include <cstdlib>

#include "servo.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t grid_gain = 16;     // the grid takes over 1/16 of SYNC's deviation
constexpr std::int64_t largest_jitter = 4; // a SYNC more than a quarter period off begins a new grid
constexpr std::int64_t slack = 8;          // an eighth of a period

} // namespace

void Interpolator::hold(double position_counts) {
    segments_.fill({position_counts, position_counts, 0});
    running_ = false;
}

void Interpolator::take(std::int64_t now_ns, double target_counts, std::int64_t period_ns) {
    const std::int64_t deviation_ns = now_ns - grid_ns_ - period_ns_;
    if (running_ && period_ns == period_ns_ && std::abs(deviation_ns) <= period_ns / largest_jitter) {
        grid_ns_ += period_ns + deviation_ns / grid_gain;
        std::shift_right(segments_.begin(), segments_.end(), 1);
    } else {
        const double here_counts = at(now_ns + Servo::step_ns);
        segments_.fill({here_counts, here_counts, now_ns});
        grid_ns_ = now_ns;
        period_ns_ = period_ns;
        running_ = true;
    }
    segments_[0] = {segments_[1].to_counts, target_counts, grid_ns_ + Servo::step_ns + period_ns / slack};
}

double Interpolator::at(std::int64_t time_ns) const {
    const auto *const running = std::find_if(segments_.begin(), segments_.end() - 1,
                                             [&](const Segment &segment) { return time_ns >= segment.start_ns; });
    const double share = static_cast<double>(time_ns - running->start_ns) / static_cast<double>(period_ns_);
    return running->from_counts + (running->to_counts - running->from_counts) * std::clamp(share, 0.0, 1.0);
}

void Profile_position::reset(double position_counts) {
    target_counts_ = position_counts;
    moving_ = waiting_ = acknowledged_ = false;
}

void Profile_position::command(bool new_set_point, bool change_at_once, double target_counts) {
    const bool rising = new_set_point && !last_bit_;
    last_bit_ = new_set_point;
    if (rising && !waiting_) {
        if (moving_ && !change_at_once) {
            next_counts_ = target_counts;
            waiting_ = true;
        } else {
            target_counts_ = target_counts;
            moving_ = true;
        }
        acknowledged_ = true;
    }
    if (!new_set_point && !waiting_) {
        acknowledged_ = false;
    }
}

void Profile_position::step(double dt_s, const Limits &limits, bool halt, Ramp &ramp) {
    if (halt || !moving_) {
        ramp.step_velocity(dt_s, 0.0, limits.deceleration_counts_per_s2);
        return;
    }
    ramp.step_position(dt_s, target_counts_, limits.speed_counts_per_s, limits.acceleration_counts_per_s2,
                       limits.deceleration_counts_per_s2);
    if (ramp.at_rest() && ramp.position_counts() == target_counts_) {
        moving_ = waiting_;
        if (waiting_) {
            target_counts_ = next_counts_;
            waiting_ = false;
            acknowledged_ = last_bit_;
        }
    }
}

} // namespace gonio::sim
