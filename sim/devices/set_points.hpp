// set_points.hpp: where the axis is told to be: cyclic targets interpolated over the cycle, and profile position.
#pragma once

#include <array>
#include <cstdint>

#include "ramp.hpp"

namespace gonio::sim {

// Cyclic synchronous position: each target is reached one interpolation period after its SYNC. The periods stand on a
// grid that follows SYNC slowly, and begin late by a step of the servo, which is computed ahead, and by an eighth of a
// period, so that SYNC's jitter becomes neither a missing set-point nor velocity.
class Interpolator {
public:
    void hold(double position_counts);
    void take(std::int64_t now_ns, double target_counts, std::int64_t period_ns);
    // At most a step of the servo ahead of the last target taken, at most an eighth of a period behind it.
    [[nodiscard]] double at(std::int64_t time_ns) const;

private:
    struct Segment {
        double from_counts = 0.0;
        double to_counts = 0.0;
        std::int64_t start_ns = 0;
    };
    std::array<Segment, 3> segments_; // newest first; with a period as short as the servo's step the delay spans two
    std::int64_t grid_ns_ = 0;
    std::int64_t period_ns_ = 1;
    bool running_ = false;
};

// Profile position: set-points by the handshake of controlword bit 4 and statusword bit 12, one in advance.
class Profile_position {
public:
    struct Limits {
        double speed_counts_per_s;
        double acceleration_counts_per_s2;
        double deceleration_counts_per_s2;
    };
    void reset(double position_counts);
    // A controlword came; the target is absolute.
    void command(bool new_set_point, bool change_at_once, double target_counts);
    void step(double dt_s, const Limits &limits, bool halt, Ramp &ramp);

    [[nodiscard]] bool acknowledged() const { return acknowledged_; }
    [[nodiscard]] bool reached() const { return !moving_; }
    // What a relative set-point adds to.
    [[nodiscard]] double last_target_counts() const { return waiting_ ? next_counts_ : target_counts_; }

private:
    double target_counts_ = 0.0;
    double next_counts_ = 0.0;
    bool moving_ = false;
    bool waiting_ = false; // next_counts_ follows
    bool last_bit_ = false;
    bool acknowledged_ = false;
};

} // namespace gonio::sim
