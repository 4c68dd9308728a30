// apparatus.hpp: all of an instrument that is not firmware: drives on a CAN bus, light, detector, digitiser, strobe,
// interlocks and shutter, on one clock. Virtual time joins it with the firmware core (World), real interfaces with
// goniod (sim/real).
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>

#include "can_bus.hpp"
#include "detector.hpp"
#include "digitiser.hpp"
#include "drive.hpp"
#include "faults.hpp"
#include "interlocks.hpp"
#include "kinematics.hpp"
#include "optics_factory.hpp"
#include "shading.hpp"
#include "strobe.hpp"
#include "truth_file.hpp"

namespace gonio::sim {

// What leaves the apparatus besides CAN frames.
struct Apparatus_outputs {
    Interlocks::Line_changed line;     // door, emergency stop, STO or limit changes
    Strobe_line::Deliver strobe_edge;  // as a kernel reports it
    Strobe_line::Put strobe_level;     // for a real line
    Digitiser::Ready packet;           // one can be read from digitiser()
    std::function<void()> host_silent; // the fault of that name happens
};

// When it was switched on, on its scheduler's clock, and how fast its bus is.
struct Apparatus_clock {
    std::int64_t start_ns = 0;
    std::uint32_t can_bits_per_s = 1000000;
    bool drives_in_step = false; // all drives take their millisecond at the same moment: fewer wake-ups in real time
};

class Apparatus {
public:
    Apparatus(const Scenario &scenario, const std::filesystem::path &truth_path, const Optics_factory &make_optics,
              Apparatus_outputs outputs, const Apparatus_clock &clock = {});
    Apparatus(const Apparatus &) = delete;
    Apparatus &operator=(const Apparatus &) = delete;
    Apparatus(Apparatus &&) = delete;
    Apparatus &operator=(Apparatus &&) = delete;
    ~Apparatus();

    // The scenario's faults count from now on.
    void arm_faults();

    [[nodiscard]] std::array<double, axis_count> position_deg(std::int64_t time_ns) const;
    [[nodiscard]] std::array<double, axis_count> speed_deg_per_s() const;
    [[nodiscard]] bool at_rest() const;
    [[nodiscard]] bool dark() const { return !shutter_.is_open(); }

    void set_shutter(bool open) { shutter_.command(open); }
    void set_lamp(bool on) { lamp_on_ = on; }
    [[nodiscard]] bool lamp_on() const { return lamp_on_; }
    void pulse_watchdog() { shutter_.pulse_watchdog(); }
    void mount_sample(bool mounted) { sample_mounted_ = mounted; }
    [[nodiscard]] bool line_level(std::uint32_t line) const;

    [[nodiscard]] Scheduler &scheduler() { return scheduler_; }
    [[nodiscard]] Can_bus &bus() { return bus_; }
    [[nodiscard]] Digitiser &digitiser() { return digitiser_; }
    [[nodiscard]] Fault_injector &faults() { return *faults_; }

    [[nodiscard]] const Scheduler &scheduler() const { return scheduler_; }
    [[nodiscard]] const Scenario &scenario() const { return scenario_; }
    [[nodiscard]] const Drive &drive(std::size_t axis) const { return *drives_.at(axis); }
    [[nodiscard]] const Can_bus &bus() const { return bus_; }
    [[nodiscard]] const Shutter &shutter() const { return shutter_; }
    [[nodiscard]] const Optics &optics() const { return *optics_; }
    [[nodiscard]] const Interlocks &interlocks() const { return interlocks_; }
    [[nodiscard]] const Strobe_line &strobe() const { return strobe_; }
    [[nodiscard]] const Digitiser &digitiser() const { return digitiser_; }
    [[nodiscard]] const Fault_injector &faults() const { return *faults_; }
    [[nodiscard]] std::int64_t running_ns() const { return scheduler_.now_ns() - start_ns_; }

    static constexpr double rest_deg_per_s = 1e-3; // an encoder count in 40 ms

private:
    [[nodiscard]] bool sample_turning() const;
    [[nodiscard]] double seconds_on(std::int64_t time_ns) const {
        return 1e-9 * static_cast<double>(time_ns - start_ns_);
    }
    [[nodiscard]] double light_counts(std::int64_t time_ns, const std::array<double, axis_count> &q_deg) const;
    gn_sample convert(std::uint64_t sample, std::int64_t time_ns);

    Scenario scenario_;
    std::int64_t start_ns_;
    Apparatus_outputs outputs_;
    Scheduler scheduler_;
    Can_bus bus_;
    std::array<std::unique_ptr<Drive>, axis_count> drives_;
    Kinematics kinematics_;
    std::unique_ptr<Optics> optics_;
    Head head_;
    Detector detector_;
    Shutter shutter_;
    Interlocks interlocks_;
    Strobe_line strobe_;
    Digitiser digitiser_;
    Truth_file truth_;
    std::unique_ptr<Fault_injector> faults_;
    bool sample_mounted_;
    bool lamp_on_ = false;
    std::uint64_t conversions_ = 0;
};

} // namespace gonio::sim
