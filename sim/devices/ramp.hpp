// ramp.hpp: set-points with bounded velocity and acceleration, for stops, homing and profile position.
#pragma once

namespace gonio::sim {

class Ramp {
public:
    void place(double position_counts, double velocity_counts_per_s) {
        position_counts_ = position_counts;
        velocity_counts_per_s_ = velocity_counts_per_s;
    }
    // Towards a velocity (0: stop).
    void step_velocity(double dt_s, double target_counts_per_s, double acceleration_counts_per_s2);
    // Towards a position, so as to come to rest there.
    void step_position(double dt_s, double target_counts, double speed_counts_per_s, double acceleration_counts_per_s2,
                       double deceleration_counts_per_s2);

    [[nodiscard]] double position_counts() const { return position_counts_; }
    [[nodiscard]] double velocity_counts_per_s() const { return velocity_counts_per_s_; }
    [[nodiscard]] bool at_rest() const { return velocity_counts_per_s_ == 0.0; }

private:
    double position_counts_ = 0.0;
    double velocity_counts_per_s_ = 0.0;
};

} // namespace gonio::sim
