// drive_parts.hpp: what a drive consists of: one CANopen device and one axis.
#pragma once

#include <array>
#include <cstdint>

#include "axis.hpp"
#include "drive.hpp"
#include "emcy.hpp"
#include "nmt.hpp"
#include "pdo.hpp"
#include "sdo_server.hpp"

namespace gonio::sim {

class Drive::Parts final : public Object_guard {
public:
    Parts(Scheduler &scheduler, Can_bus &bus, Can_node &self, const Drive_config &drive_config);

    void on_frame(const gn_can_frame &frame);
    void set_sto(bool torque_allowed);
    void power(bool on);
    void raise_emcy(std::uint16_t code);
    [[nodiscard]] std::uint16_t statusword() const { return static_cast<std::uint16_t>(objects_.statusword.value); }

    // Object_guard
    std::uint32_t before_read(Od_entry &entry) override;
    std::uint32_t before_write(const Od_entry &entry, std::int64_t value) override;
    void after_write(Od_entry &entry) override;

    Drive_config config;
    Drive_counters counters;
    bool silent = false;
    bool skip_sync = false;
    Nmt_state nmt = Nmt_state::initialising;
    Scheduler &scheduler;

private:
    Can_bus &bus_;
    int bus_index_;
    Object_dictionary dictionary_;
    Drive_objects objects_;

public:
    Axis axis;

private:
    void tick();
    void schedule_tick();
    void nmt_command(Nmt_command command);
    void enter_initialising(bool node);
    void on_sync(const gn_can_frame &frame);
    void on_sdo(const gn_can_frame &frame);
    void on_rpdo(Rpdo &rpdo, const gn_can_frame &frame);
    void send_sdo(const Sdo_server::Message &message);
    void send_due_pdos(std::int64_t latch_ns);
    void send_tpdo(Tpdo &tpdo);
    void watch_communication();
    void communication_back();
    void commanded();
    // 0x6007: what the drive does when its connection breaks.
    void abort_connection(std::uint16_t code);
    void emergency(std::uint16_t code, std::uint32_t detail);
    void transmit(const gn_can_frame &frame);
    void refresh_communication(); // SYNC and heartbeat consumer
    void refresh_pdos();

    Sdo_server sdo_;
    std::array<Rpdo, 2> rpdos_;
    std::array<Tpdo, 2> tpdos_;
    std::array<bool, 2> tpdo_due_{};
    Heartbeat_producer producer_;
    Heartbeat_consumer consumer_;
    Emergency emergency_;
    Od_entry &sync_window_us_;
    Od_entry &sync_overflow_;
    std::uint32_t sync_id_ = 0x80;
    std::int64_t boot_due_ns_ = 0;
    bool powered_ = true;
    bool communication_lost_ = false;
    bool sync_length_wrong_ = false;
    bool pdo_length_wrong_ = false;
};

} // namespace gonio::sim
