// drive.hpp: a simulated CiA 402 stepper drive with encoder: a CANopen node whose axis moves.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "can_bus.hpp"
#include "eds.hpp"
#include "scheduler.hpp"

namespace gonio::sim {

// Positions are axis coordinates: counts = counts_per_deg * degrees, zero where CONVENTIONS.md has it.
struct Drive_config {
    std::uint8_t node = 1;
    std::string name;
    std::filesystem::path eds_directory;    // protocol/eds
    std::string personality = "full";       // full, basic, fixed
    std::vector<Object_name> without;       // objects of the personality that this drive lacks
    std::uint32_t counts_per_turn = 400000; // 0x608F
    std::uint32_t serial = 1;               // 0x1018:04
    bool absent = false;                    // never answers, never moves
    bool inverted = false;                  // the motor turns the other way than its encoder counts: wrong wiring
    bool tick_in_step = false;              // its millisecond begins with the other drives'

    double initial_position_counts = 0.0; // where it stands at power-up; 0x6064 reads 0 there
    // The index pulse that homing method 1 finds: the encoder count nearest to this. The negative switch opens
    // `switch_to_index_counts` before it, on the way out.
    double negative_switch_counts = -1.0e6;
    double switch_to_index_counts = 700.0;

    double latch_delay_us = 0.0;      // 0x6064 in a TPDO is the position this long after SYNC's reception
    double tpdo_processing_us = 40.0; // from latching to the TPDO's request for the bus
    double sdo_response_us = 250.0;
    double boot_ms = 60.0; // from reset to the boot-up message

    double bandwidth_hz = 50.0;                    // critically damped follower of second order
    double max_acceleration_counts_per_s2 = 1.0e6; // what the motor's torque can do with the load's inertia
    double friction_counts_per_s2 = 3.0e5;         // deceleration of the free axis
    double gravity_counts_per_s2 = 0.0;            // acceleration of the free axis, signed
    bool brake = false;                            // holds the axis while there is no torque
    double brake_engage_ms = 30.0;
    double brake_release_ms = 40.0;
};

struct Drive_counters {
    std::uint64_t syncs = 0;
    std::uint64_t tpdos = 0;
    std::uint64_t rpdos = 0;
    std::uint64_t sdo_requests = 0;
    std::uint64_t sdo_aborts = 0;
    std::uint64_t emergencies = 0;
    std::uint64_t boot_ups = 0;
};

class Drive final : public Can_node {
public:
    // Powers up at the scheduler's present time. Throws std::runtime_error for an unknown personality, a bad EDS, or a
    // drive without an object that it does not have or cannot do without.
    Drive(Scheduler &scheduler, Can_bus &bus, const Drive_config &config);
    ~Drive() override;
    Drive(const Drive &) = delete;
    Drive &operator=(const Drive &) = delete;
    Drive(Drive &&) = delete;
    Drive &operator=(Drive &&) = delete;

    void on_frame(const gn_can_frame &frame) override;

    // The axis, any time from 50 ms ago up to now.
    [[nodiscard]] double true_position_counts(std::int64_t time_ns) const;
    [[nodiscard]] double true_velocity_counts_per_s() const;

    // Faults and inputs from outside.
    void set_sto(bool torque_allowed);
    void block(bool blocked);            // something holds the axis mechanically
    void silence(bool silent);           // the node says nothing more, and goes on otherwise
    void power(bool on);                 // off: dead to the bus and without torque; on: it starts as after a reset
    void skip_next_sync();               // neither latches nor takes over set-points at the next SYNC
    void raise_emcy(std::uint16_t code); // as if the drive had found a fault of its own: EMCY and fault reaction

    [[nodiscard]] bool energised() const; // the motor has torque
    [[nodiscard]] bool homed() const;
    [[nodiscard]] bool brake_closed() const;
    [[nodiscard]] std::uint16_t statusword() const;
    [[nodiscard]] std::uint8_t nmt_state() const; // as in the heartbeat: 0, 4, 5, 127
    [[nodiscard]] const Drive_counters &counters() const;
    [[nodiscard]] const Drive_config &config() const;

private:
    class Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace gonio::sim
