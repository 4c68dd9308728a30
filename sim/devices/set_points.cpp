// set_points.cpp: profile position.
#include "set_points.hpp"

namespace gonio::sim {

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
