// kinematics.hpp: from axis angles to directions, written from CONVENTIONS.md and independent of the host's.
#pragma once

#include <array>

#include "instrument.hpp"
#include "optics.hpp"

namespace gonio::sim {

struct Directions {
    Vec3 incident; // all in the sample frame, unit; away from the sample
    Vec3 outgoing;
    Vec3 lab_up; // the lab's +Y
};

// Each axis is a turn about a vector given at zero, carried by the earlier axes of its chain. The sample frame is the
// lab's when all read zero (+Z towards the source).
class Kinematics {
public:
    explicit Kinematics(const std::array<Axis_settings, axis_count> &axes);
    [[nodiscard]] Directions directions(const std::array<double, axis_count> &q_deg) const;

private:
    struct Turn {
        Vec3 vector;
        bool carries_sample;
    };
    std::array<Turn, axis_count> turns_;
};

} // namespace gonio::sim
