// world.hpp: one simulated instrument: drives, light, detector, digitiser, interlocks and the firmware core, on one
// virtual clock.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "detector.hpp"
#include "faults.hpp"
#include "kinematics.hpp"
#include "optics_factory.hpp"
#include "port_sim.hpp"
#include "shading.hpp"
#include "truth_file.hpp"

namespace gonio::sim {

// What is known about the end of a run.
struct Standstill {
    bool watching = false;
    bool reached = false;
    std::int64_t since_ns = 0;        // when the host was lost
    std::int64_t standstill_ns = 0;   // when the axes stood
    std::int64_t dark_ns = 0;         // when the shutter was shut; 0: not yet
    double max_speed_deg_per_s = 0.0; // between the two
    double max_speed_after_deg_per_s = 0.0;
};

class World final : private Board {
public:
    World(const Scenario &scenario, Carrier &carrier, const std::filesystem::path &truth_path,
          const Optics_factory &make_optics = closed_form_optics);
    ~World() override;
    World(const World &) = delete;
    World &operator=(const World &) = delete;
    World(World &&) = delete;
    World &operator=(World &&) = delete;

    [[nodiscard]] Scheduler &scheduler() { return scheduler_; }
    // Bytes from a client are there, or one came or went.
    void link_changed() { port_->on_link(); }
    // From now on the way to standstill is watched.
    void host_lost();

    [[nodiscard]] std::array<double, axis_count> position_deg(std::int64_t time_ns) const;
    [[nodiscard]] std::array<double, axis_count> speed_deg_per_s() const;
    [[nodiscard]] bool at_rest() const;
    [[nodiscard]] bool dark() const { return !shutter_.is_open(); }

    // For the journal.
    [[nodiscard]] const Scenario &scenario() const { return scenario_; }
    [[nodiscard]] const Drive &drive(std::size_t axis) const { return *drives_.at(axis); }
    [[nodiscard]] const Can_bus &bus() const { return bus_; }
    [[nodiscard]] const Shutter &shutter() const { return shutter_; }
    [[nodiscard]] const Optics &optics() const { return *optics_; }
    [[nodiscard]] const Interlocks &interlocks() const { return interlocks_; }
    [[nodiscard]] const Strobe_line &strobe() const { return strobe_; }
    [[nodiscard]] const Digitiser &digitiser() const { return digitiser_; }
    [[nodiscard]] const Fault_injector &faults() const { return *faults_; }
    [[nodiscard]] const Standstill &standstill() const { return standstill_; }
    [[nodiscard]] const gonio_Status &last_status() const { return last_status_; }
    [[nodiscard]] const std::string &last_fault() const { return last_fault_; }
    [[nodiscard]] const std::vector<std::string> &log_lines() const { return log_lines_; }
    [[nodiscard]] std::uint32_t paths() const { return paths_; }

private:
    void set_output(std::uint32_t output, bool on) override;
    void pulse_watchdog() override { shutter_.pulse_watchdog(); }
    void operator_done(std::uint32_t action) override;
    bool digitiser_start(std::uint32_t sample_period_us, std::uint32_t samples_per_strobe) override;
    void digitiser_stop() override { digitiser_.stop(); }
    int digitiser_read(std::uint8_t *buffer, std::size_t capacity) override {
        return digitiser_.read(buffer, capacity);
    }
    [[nodiscard]] bool line_level(std::uint32_t line) const override;
    void log(int level, const std::string &text) override;
    void told(const gonio_Event &event) override;

    [[nodiscard]] bool sample_turning() const;
    [[nodiscard]] double light_counts(std::int64_t time_ns, const std::array<double, axis_count> &q_deg) const;
    gn_sample convert(std::uint64_t sample, std::int64_t time_ns);
    void watch();

    Scenario scenario_;
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
    std::unique_ptr<Port_sim> port_;
    std::unique_ptr<Fault_injector> faults_;
    bool sample_mounted_;
    bool lamp_on_ = false;
    std::uint64_t conversions_ = 0;
    Standstill standstill_;
    gonio_Status last_status_ = gonio_Status_init_zero;
    std::string last_fault_;
    std::vector<std::string> log_lines_;
    std::uint32_t paths_ = 0;
};

} // namespace gonio::sim
