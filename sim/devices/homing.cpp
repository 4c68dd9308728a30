// homing.cpp: homing, step by step.
#include "homing.hpp"

namespace gonio::sim {
namespace {

std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
    return a / b - (a % b < 0 ? 1 : 0);
}

} // namespace

void Homing::start(const Homing_parameters &parameters, const Homing_input &input) {
    parameters_ = parameters;
    if (!supports(parameters.method)) {
        phase_ = Phase::failed;
    } else if (parameters.method == 1) {
        phase_ = input.negative_switch ? Phase::leave_switch : Phase::seek_switch;
    } else {
        home_counts_ = input.encoder_counts;
        phase_ = Phase::attained;
    }
}

void Homing::interrupt() {
    if (running()) {
        phase_ = Phase::give_up;
    }
}

// The counter is latched by the pulse itself, so the count is exact however long the step is.
bool Homing::index_passed(const Homing_input &input, std::int64_t &where) const {
    const std::int64_t turn = floor_divide(input.encoder_counts - index_counts_, counts_per_turn_);
    where = index_counts_ + turn * counts_per_turn_;
    return input.encoder_before_counts < where && where <= input.encoder_counts;
}

void Homing::step(double dt_s, const Homing_input &input, Ramp &ramp) {
    switch (phase_) {
    case Phase::seek_switch:
        if (input.negative_switch) {
            phase_ = Phase::leave_switch;
        }
        break;
    case Phase::leave_switch:
        if (!input.negative_switch && ramp.velocity_counts_per_s() > 0.0) {
            phase_ = Phase::seek_index;
        }
        break;
    case Phase::seek_index:
        if (index_passed(input, home_counts_)) {
            phase_ = Phase::stop;
        }
        break;
    case Phase::stop:
        if (ramp.at_rest() && input.settled) {
            phase_ = Phase::attained;
        }
        break;
    case Phase::give_up:
        if (ramp.at_rest()) {
            phase_ = Phase::idle;
        }
        break;
    case Phase::idle:
    case Phase::attained:
    case Phase::failed:
        break;
    }
    double velocity = 0.0;
    if (phase_ == Phase::seek_switch) {
        velocity = -parameters_.fast_counts_per_s;
    } else if (phase_ == Phase::leave_switch || phase_ == Phase::seek_index) {
        velocity = parameters_.slow_counts_per_s;
    }
    ramp.step_velocity(dt_s, velocity, parameters_.acceleration_counts_per_s2);
}

} // namespace gonio::sim
