// faults.cpp: what each kind of fault does.
#include "faults.hpp"

#include <cmath>

namespace gonio::sim {
namespace {

constexpr std::uint32_t sync_id = 0x080;
constexpr std::uint32_t first_tpdo_id = 0x180;

} // namespace

Fault_injector::Fault_injector(const std::vector<Fault> &faults, const Fault_targets &targets)
    : faults_(faults), targets_(targets) {
    bool judged = false;
    for (const Fault &fault : faults_) {
        judged = judged || fault.kind == Fault_kind::sync_lost || fault.kind == Fault_kind::tpdo_late;
        if (fault.after_path == 0) {
            targets_.scheduler.after(std::llround(fault.at_s * 1e9), [this, &fault] { happen(fault); });
        }
    }
    if (judged) {
        watch_bus();
    }
}

void Fault_injector::watch_bus() {
    targets_.bus.set_judge(
        [this](const gn_can_frame &frame, std::int64_t, std::int64_t &delay_ns) { return judge(frame, delay_ns); });
}

void Fault_injector::path_began() {
    ++paths_;
    for (const Fault &fault : faults_) {
        if (fault.after_path == paths_) {
            targets_.scheduler.after(std::llround(fault.at_s * 1e9), [this, &fault] { happen(fault); });
        }
    }
}

void Fault_injector::inject(const Fault &fault) {
    watch_bus();
    targets_.scheduler.after(std::llround(fault.at_s * 1e9), [this, fault] { happen(fault); });
}

void Fault_injector::clear() {
    for (auto &drive : targets_.drives) {
        drive->silence(false);
        drive->block(false);
        drive->power(true);
    }
    targets_.interlocks.set_sto(true);
    targets_.interlocks.set_door(true);
    targets_.interlocks.set_emergency_stop(true);
    targets_.interlocks.set_limit(true);
    targets_.strobe.stick(false);
    targets_.strobe.double_pulses(0);
    syncs_to_lose_ = 0;
    tpdos_to_delay_.clear();
}

void Fault_injector::happen(const Fault &fault) {
    switch (fault.kind) {
    case Fault_kind::strobe_lost:
        targets_.strobe.lose(fault.count, fault.counted);
        injected_["strobe_lost"] += fault.count;
        break;
    case Fault_kind::strobe_extra:
        targets_.strobe.disturb();
        ++injected_["strobe_extra"];
        break;
    case Fault_kind::strobe_stuck:
        targets_.strobe.stick(true);
        ++injected_["strobe_stuck"];
        break;
    case Fault_kind::strobe_doubled:
        targets_.strobe.double_pulses(fault.count);
        injected_["strobe_doubled"] += fault.count;
        break;
    case Fault_kind::sync_lost:
        syncs_to_lose_ += fault.count;
        break;
    case Fault_kind::packet_lost:
        for (std::uint32_t i = 0; i < fault.count; ++i) {
            targets_.digitiser.lose_packet();
        }
        injected_["packet_lost"] += fault.count;
        break;
    case Fault_kind::packet_counter_start: // in the digitiser's configuration
        ++injected_["packet_counter_start"];
        break;
    case Fault_kind::sto_open:
        targets_.interlocks.set_sto(false);
        ++injected_["sto_open"];
        break;
    case Fault_kind::door_open:
        targets_.interlocks.set_door(false);
        ++injected_["door_open"];
        break;
    case Fault_kind::limit:
        targets_.interlocks.set_limit(false);
        ++injected_["limit"];
        break;
    case Fault_kind::emergency_stop:
        targets_.interlocks.set_emergency_stop(false);
        ++injected_["emergency_stop"];
        break;
    case Fault_kind::host_silent:
        if (targets_.silence_host) {
            targets_.silence_host();
            ++injected_["host_silent"];
        }
        break;
    default:
        happen_to_drive(fault);
        break;
    }
}

void Fault_injector::happen_to_drive(const Fault &fault) {
    Drive &drive = *targets_.drives.at(fault.axis);
    switch (fault.kind) {
    case Fault_kind::tpdo_late:
        tpdos_to_delay_[first_tpdo_id + drive.config().node] = {fault.count, std::llround(fault.delay_us * 1e3)};
        break;
    case Fault_kind::drive_misses_sync:
        drive.skip_next_sync();
        ++injected_["drive_misses_sync"];
        break;
    case Fault_kind::node_silent:
        drive.silence(true);
        ++injected_["node_silent"];
        break;
    case Fault_kind::node_missing:
        drive.power(false);
        ++injected_["node_missing"];
        break;
    case Fault_kind::emcy:
        drive.raise_emcy(static_cast<std::uint16_t>(fault.value));
        ++injected_["emcy"];
        break;
    case Fault_kind::blocked:
        drive.block(true);
        ++injected_["blocked"];
        break;
    default:
        break;
    }
}

Frame_fate Fault_injector::judge(const gn_can_frame &frame, std::int64_t &delay_ns) {
    if (frame.id == sync_id && syncs_to_lose_ > 0) {
        --syncs_to_lose_;
        ++injected_["sync_lost"];
        return Frame_fate::lose;
    }
    if (auto const late = tpdos_to_delay_.find(frame.id); late != tpdos_to_delay_.end() && late->second.first > 0) {
        --late->second.first;
        ++injected_["tpdo_late"];
        delay_ns = late->second.second;
        return Frame_fate::delay;
    }
    return Frame_fate::deliver;
}

} // namespace gonio::sim
