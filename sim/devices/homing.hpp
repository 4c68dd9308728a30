// homing.hpp: homing methods of CiA 402: 1 (negative limit switch, then index pulse), 35 and 37 (where it stands).
#pragma once

#include <cstdint>

#include "ramp.hpp"

namespace gonio::sim {

struct Homing_parameters {
    std::int64_t method = 0;                 // 0x6098
    double fast_counts_per_s = 0.0;          // 0x6099:01
    double slow_counts_per_s = 0.0;          // 0x6099:02
    double acceleration_counts_per_s2 = 0.0; // 0x609A
};

// What the drive senses in a step; encoder counts are those since power-up or any other fixed origin.
struct Homing_input {
    std::int64_t encoder_before_counts = 0;
    std::int64_t encoder_counts = 0;
    bool negative_switch = false;
    bool settled = false; // the axis has followed the set-point
};

class Homing {
public:
    // Index pulses are at index_counts + n * counts_per_turn.
    Homing(std::int64_t index_counts, std::int64_t counts_per_turn)
        : index_counts_(index_counts), counts_per_turn_(counts_per_turn) {}

    static bool supports(std::int64_t method) { return method == 1 || method == 35 || method == 37; }

    void start(const Homing_parameters &parameters, const Homing_input &input);
    void interrupt(); // comes to rest, home stays unknown
    void fail() { phase_ = running() ? Phase::failed : phase_; }
    void reset() { phase_ = Phase::idle; }
    // Move the set-point on by one step.
    void step(double dt_s, const Homing_input &input, Ramp &ramp);

    [[nodiscard]] bool running() const {
        return phase_ != Phase::idle && phase_ != Phase::attained && phase_ != Phase::failed;
    }
    [[nodiscard]] bool attained() const { return phase_ == Phase::attained; }
    [[nodiscard]] bool failed() const { return phase_ == Phase::failed; }
    // Encoder count of the home position, once attained.
    [[nodiscard]] std::int64_t home_counts() const { return home_counts_; }

private:
    enum class Phase { idle, seek_switch, leave_switch, seek_index, stop, give_up, attained, failed };
    [[nodiscard]] bool index_passed(const Homing_input &input, std::int64_t &where) const;

    std::int64_t index_counts_;
    std::int64_t counts_per_turn_;
    Homing_parameters parameters_;
    Phase phase_ = Phase::idle;
    std::int64_t home_counts_ = 0;
};

} // namespace gonio::sim
