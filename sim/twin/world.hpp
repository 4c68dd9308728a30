// world.hpp: the apparatus and the firmware core on one virtual clock, and what is heard of the firmware.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apparatus.hpp"
#include "port_sim.hpp"

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

    [[nodiscard]] Scheduler &scheduler() { return apparatus_.scheduler(); }
    // Bytes from a client are there, or one came or went.
    void link_changed() { port_->on_link(); }
    // From now on the way to standstill is watched.
    void host_lost();

    [[nodiscard]] const Apparatus &apparatus() const { return apparatus_; }
    [[nodiscard]] bool at_rest() const { return apparatus_.at_rest(); }
    [[nodiscard]] bool dark() const { return apparatus_.dark(); }

    // For the journal.
    [[nodiscard]] const Standstill &standstill() const { return standstill_; }
    [[nodiscard]] const gonio_Status &last_status() const { return last_status_; }
    [[nodiscard]] const std::string &last_fault() const { return last_fault_; }
    [[nodiscard]] const std::vector<std::string> &log_lines() const { return log_lines_; }
    [[nodiscard]] std::uint32_t paths() const { return paths_; }

private:
    void set_output(std::uint32_t output, bool on) override;
    void pulse_watchdog() override { apparatus_.pulse_watchdog(); }
    void operator_done(std::uint32_t action) override;
    bool digitiser_start(std::uint32_t sample_period_us, std::uint32_t samples_per_strobe) override {
        return apparatus_.digitiser().start(sample_period_us, samples_per_strobe);
    }
    void digitiser_stop() override { apparatus_.digitiser().stop(); }
    int digitiser_read(std::uint8_t *buffer, std::size_t capacity) override {
        return apparatus_.digitiser().read(buffer, capacity);
    }
    [[nodiscard]] bool line_level(std::uint32_t line) const override { return apparatus_.line_level(line); }
    void log(int level, const std::string &text) override;
    void told(const gonio_Event &event) override;

    void watch();

    Carrier &carrier_;
    Apparatus apparatus_;
    std::unique_ptr<Port_sim> port_;
    Standstill standstill_;
    gonio_Status last_status_ = gonio_Status_init_zero;
    std::string last_fault_;
    std::vector<std::string> log_lines_;
    std::uint32_t paths_ = 0;
};

} // namespace gonio::sim
