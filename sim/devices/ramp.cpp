// ramp.cpp: trapezoidal set-points, step by step.
#include "ramp.hpp"

#include <algorithm>
#include <cmath>

namespace gonio::sim {

void Ramp::step_velocity(double dt_s, double target_counts_per_s, double acceleration_counts_per_s2) {
    const double most = acceleration_counts_per_s2 * dt_s;
    const double before = velocity_counts_per_s_;
    velocity_counts_per_s_ += std::clamp(target_counts_per_s - before, -most, most);
    position_counts_ += 0.5 * (before + velocity_counts_per_s_) * dt_s;
}

void Ramp::step_position(double dt_s, double target_counts, double speed_counts_per_s,
                         double acceleration_counts_per_s2, double deceleration_counts_per_s2) {
    const double distance = target_counts - position_counts_;
    const double loss = deceleration_counts_per_s2 * dt_s; // of velocity per step
    if (std::abs(distance) <= 0.5 * loss * dt_s && std::abs(velocity_counts_per_s_) <= loss) {
        place(target_counts, 0.0);
        return;
    }
    // The velocity from which whole steps of this deceleration end at the target: v (v / loss + 1) dt / 2 = distance,
    // counted from the end of this step.
    const double ahead = std::max(0.0, std::abs(distance) - 0.5 * std::abs(velocity_counts_per_s_) * dt_s);
    const double stoppable = loss * (std::sqrt(0.25 + 2.0 * ahead / (loss * dt_s)) - 0.5);
    const double wanted = std::copysign(std::min(speed_counts_per_s, stoppable), distance);
    const bool slower = std::abs(wanted) < std::abs(velocity_counts_per_s_) || wanted * velocity_counts_per_s_ < 0.0;
    step_velocity(dt_s, wanted, slower ? deceleration_counts_per_s2 : acceleration_counts_per_s2);
}

} // namespace gonio::sim
