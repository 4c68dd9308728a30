// brake.hpp: a holding brake and the torque that bridges its delays: on before it opens, off after it has closed.
#pragma once

#include <cstdint>

namespace gonio::sim {

struct Brake_config {
    bool fitted = false;
    std::int64_t engage_ns = 30'000'000;
    std::int64_t release_ns = 40'000'000;
};

class Brake {
public:
    explicit Brake(const Brake_config &config) : config_(config), closed_(config.fitted) {}

    // Once per step. wanted: the state machine has the axis under control; possible: STO permits torque; forced: 0x60FE
    // demands the brake; slow: the axis is slow enough to be held while the brake closes.
    void step(std::int64_t now_ns, bool wanted, bool possible, bool forced, bool slow);

    [[nodiscard]] bool closed() const { return closed_ || forced_; }
    [[nodiscard]] bool torque() const { return torque_; }

private:
    Brake_config config_;
    bool closed_;
    bool forced_ = false;
    bool torque_ = false;
    bool wanted_ = false;
    bool bridging_ = false;
    std::int64_t since_ns_ = 0; // of the last change of wanted_
};

} // namespace gonio::sim
