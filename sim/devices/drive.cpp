// drive.cpp: a drive as a whole: power-up, its millisecond, inputs from outside.
#include "drive.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "drive_parts.hpp"
#include "personality.hpp"

namespace gonio::sim {
namespace {

constexpr double ns_per_ms = 1.0e6;
// The drives' millisecond ticks are not in step with each other.
constexpr std::int64_t tick_phase_ns = 137'000;

// What the drive looks up while it runs; all else that it needs is looked up at power-up, and missed there.
bool needed_later(const Object_name &name) {
    static constexpr std::array<std::uint16_t, 6> whole{0x1001, 0x1003, 0x1005, 0x1006, 0x1014, 0x1016};
    const bool pdo = name.index >= 0x1400 && name.index < 0x1C00;
    const bool mapping = (name.index & 0x0200U) != 0;
    constexpr unsigned id_and_type = 2;
    return std::find(whole.begin(), whole.end(), name.index) != whole.end() ||
           (pdo && (mapping || name.subindex.value_or(0) <= id_and_type));
}

Object_dictionary make_dictionary(const Drive_config &config) {
    Eds_file eds = load_personality(config.personality, config.eds_directory);
    for (const Object_name &name : config.without) {
        if (needed_later(name)) {
            throw std::runtime_error("the drive cannot be without object " + object_text(name));
        }
        take_out(eds, name);
    }
    Object_dictionary dictionary(eds, config.node);
    dictionary.at(0x608F, 1).default_value = config.counts_per_turn;
    dictionary.at(0x6092, 1).default_value = config.counts_per_turn;
    dictionary.at(0x1018, 4).default_value = config.serial;
    dictionary.reset(0x0000, 0xFFFF);
    return dictionary;
}

Axis_config axis_config(const Drive_config &config) {
    Axis_config axis;
    axis.inverted = config.inverted;
    axis.servo = {config.bandwidth_hz, config.max_acceleration_counts_per_s2, config.friction_counts_per_s2,
                  config.gravity_counts_per_s2};
    axis.brake = {config.brake, std::llround(config.brake_engage_ms * ns_per_ms),
                  std::llround(config.brake_release_ms * ns_per_ms)};
    axis.initial_position_counts = config.initial_position_counts;
    axis.index_counts = std::llround(config.negative_switch_counts);
    axis.counts_per_turn = config.counts_per_turn;
    axis.switch_counts = static_cast<double>(axis.index_counts) - config.switch_to_index_counts;
    return axis;
}

std::int64_t tick_phase_of(const Drive_config &config) {
    return config.tick_in_step ? 0 : config.node * tick_phase_ns % Servo::step_ns;
}

} // namespace

Drive::Parts::Parts(Scheduler &time, Can_bus &bus, Can_node &self, const Drive_config &drive_config)
    : config(drive_config), scheduler(time), bus_(bus), bus_index_(bus.attach(self)),
      dictionary_(make_dictionary(drive_config)), objects_(dictionary_),
      axis(axis_config(drive_config), objects_, time.now_ns() + tick_phase_of(drive_config)),
      sdo_(dictionary_, *this), rpdos_{Rpdo(dictionary_, 0x1400, 0x1600), Rpdo(dictionary_, 0x1401, 0x1601)},
      tpdos_{Tpdo(dictionary_, 0x1800, 0x1A00), Tpdo(dictionary_, 0x1801, 0x1A01)},
      producer_(dictionary_, drive_config.node), consumer_(dictionary_), emergency_(dictionary_),
      sync_window_us_(dictionary_.at(0x1007)), sync_overflow_(dictionary_.at(0x1019)) {
    boot_due_ns_ = time.now_ns() + std::llround(config.boot_ms * ns_per_ms);
    if (!config.absent) {
        schedule_tick();
    }
}

void Drive::Parts::schedule_tick() {
    scheduler.at(axis.next_step_ns(), [this] { tick(); });
}

void Drive::Parts::tick() {
    const std::int64_t now_ns = scheduler.now_ns();
    if (const std::uint16_t code = axis.step(); code != 0) {
        emergency(code, 0);
    }
    schedule_tick();
    if (nmt == Nmt_state::initialising) {
        if (now_ns >= boot_due_ns_) {
            gn_can_frame boot_up = producer_.frame(Nmt_state::initialising);
            nmt = Nmt_state::pre_operational;
            producer_.restart(now_ns);
            ++counters.boot_ups;
            transmit(boot_up);
        }
        return;
    }
    if (producer_.due(now_ns)) {
        transmit(producer_.frame(nmt));
    }
    watch_communication();
    if (const auto message = sdo_.check_timeout(now_ns)) {
        send_sdo(*message);
    }
    if (nmt == Nmt_state::operational) {
        axis.latch(now_ns);
        for (Tpdo &tpdo : tpdos_) {
            if (tpdo.due_by_event(now_ns)) {
                send_tpdo(tpdo);
            }
        }
    }
}

void Drive::Parts::watch_communication() {
    const std::int64_t now_ns = scheduler.now_ns();
    if (const std::uint8_t producer = consumer_.lost(now_ns); producer != 0) {
        communication_lost_ = true;
        emergency(emcy::heartbeat_lost, producer);
        abort_connection(emcy::heartbeat_lost);
        // 0x1029:01: 0 (also where the object is missing) pre-operational, 1 no change, 2 stopped.
        const Od_entry *behaviour = dictionary_.find(0x1029, 1);
        const std::int64_t option = behaviour != nullptr ? behaviour->value : 0;
        if (option == 2) {
            nmt_command(Nmt_command::stop);
        } else if (option == 0 && nmt == Nmt_state::operational) {
            nmt_command(Nmt_command::enter_pre_operational);
        }
    }
    for (std::uint32_t k = 0; k < rpdos_.size(); ++k) {
        if (nmt == Nmt_state::operational && rpdos_[k].deadline_missed(now_ns)) {
            communication_lost_ = true;
            emergency(emcy::rpdo_deadline, k + 1);
            abort_connection(emcy::rpdo_deadline);
        }
    }
}

void Drive::Parts::abort_connection(std::uint16_t code) {
    if (!axis.state().energised()) {
        return;
    }
    constexpr std::int64_t no_action = 0, fault_signal = 1, disable_voltage = 2;
    const std::int64_t option = objects_.abort_connection != nullptr ? objects_.abort_connection->value : fault_signal;
    if (option == fault_signal) {
        axis.fault(code);
    } else if (option == disable_voltage) {
        axis.disable_voltage();
    } else if (option != no_action) {
        axis.quick_stop();
    }
}

void Drive::Parts::communication_back() {
    communication_lost_ = false;
    if (axis.state().state() != Drive_state::fault && axis.state().state() != Drive_state::fault_reaction_active) {
        transmit(emergency_.clear());
    }
}

void Drive::Parts::emergency(std::uint16_t code, std::uint32_t detail) {
    ++counters.emergencies;
    const gn_can_frame frame = emergency_.raise(code, detail);
    if (emergency_.enabled() && (nmt == Nmt_state::operational || nmt == Nmt_state::pre_operational)) {
        transmit(frame);
    }
}

void Drive::Parts::transmit(const gn_can_frame &frame) {
    if (!silent) {
        bus_.send(bus_index_, frame);
    }
}

void Drive::Parts::set_sto(bool torque_allowed) {
    if (axis.set_torque_allowed(torque_allowed) && !config.absent) {
        emergency(emcy::sto, 0);
    }
}

void Drive::Parts::power(bool on) {
    if (on == powered_ || config.absent) {
        return;
    }
    if (on) {
        enter_initialising(true);
    } else {
        nmt = Nmt_state::initialising; // hears nothing
        boot_due_ns_ = INT64_MAX;      // and says nothing
        axis.disable_voltage();
    }
    powered_ = on;
}

void Drive::Parts::raise_emcy(std::uint16_t code) {
    if (!config.absent) {
        emergency(code, 0);
        axis.fault(code);
    }
}

Drive::Drive(Scheduler &scheduler, Can_bus &bus, const Drive_config &config)
    : parts_(std::make_unique<Parts>(scheduler, bus, *this, config)) {}

Drive::~Drive() = default;

void Drive::on_frame(const gn_can_frame &frame) {
    parts_->on_frame(frame);
}

double Drive::true_position_counts(std::int64_t time_ns) const {
    return parts_->axis.servo().position_counts(time_ns);
}

double Drive::true_velocity_counts_per_s() const {
    return parts_->axis.servo().velocity_counts_per_s(parts_->scheduler.now_ns());
}

void Drive::set_sto(bool torque_allowed) {
    parts_->set_sto(torque_allowed);
}
void Drive::block(bool blocked) {
    parts_->axis.block(blocked);
}
void Drive::silence(bool silent) {
    parts_->silent = silent;
}
void Drive::power(bool on) {
    parts_->power(on);
}
void Drive::skip_next_sync() {
    parts_->skip_sync = true;
}
void Drive::raise_emcy(std::uint16_t code) {
    parts_->raise_emcy(code);
}

bool Drive::energised() const {
    return parts_->axis.torque();
}
bool Drive::homed() const {
    return parts_->axis.homed();
}
bool Drive::brake_closed() const {
    return parts_->axis.brake_closed();
}
std::uint16_t Drive::statusword() const {
    return parts_->statusword();
}
std::uint8_t Drive::nmt_state() const {
    return static_cast<std::uint8_t>(parts_->nmt);
}
const Drive_counters &Drive::counters() const {
    return parts_->counters;
}
const Drive_config &Drive::config() const {
    return parts_->config;
}

} // namespace gonio::sim
