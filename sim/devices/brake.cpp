// brake.cpp: sequence of torque and brake.
#include "brake.hpp"

namespace gonio::sim {

void Brake::step(std::int64_t now_ns, bool wanted, bool possible, bool forced, bool slow) {
    wanted = wanted && possible;
    if (wanted != wanted_) {
        wanted_ = wanted;
        since_ns_ = now_ns;
        bridging_ = !wanted && config_.fitted && slow;
    }
    if (config_.fitted) {
        const std::int64_t passed_ns = now_ns - since_ns_;
        if (wanted && passed_ns >= config_.release_ns) {
            closed_ = false;
        } else if (!wanted && passed_ns >= config_.engage_ns) {
            closed_ = true;
        }
        bridging_ = bridging_ && !closed_ && possible;
        forced_ = forced;
    }
    torque_ = wanted || bridging_;
}

} // namespace gonio::sim
