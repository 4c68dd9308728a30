// drive_frames.cpp: a drive at the bus: NMT, SYNC, PDOs, SDO and heartbeats as they come in.
#include <algorithm>
#include <cmath>

#include "drive_parts.hpp"

namespace gonio::sim {
namespace {

constexpr double ns_per_us = 1.0e3;
constexpr double ns_per_ms = 1.0e6;
constexpr std::uint16_t communication_lost_code = 0x8100;
// A reset of the communication only does not restart the drive's processor.
constexpr double communication_reset_ms = 5.0;

} // namespace

void Drive::Parts::on_frame(const gn_can_frame &frame) {
    if (frame.own_echo || config.absent || nmt == Nmt_state::initialising) {
        return;
    }
    if (frame.id == sync_id_) {
        on_sync(frame);
        return;
    }
    if (nmt == Nmt_state::operational) {
        for (Rpdo &rpdo : rpdos_) {
            if (rpdo.exists() && frame.id == rpdo.id()) {
                on_rpdo(rpdo, frame);
                return;
            }
        }
    }
    if (frame.id == 0x600U + config.node) {
        on_sdo(frame);
    } else if (frame.id == 0 && frame.length >= 2 && (frame.data[1] == 0 || frame.data[1] == config.node)) {
        nmt_command(static_cast<Nmt_command>(frame.data[0]));
    } else if (frame.id > 0x700 && frame.id < 0x780) {
        if (consumer_.receive(static_cast<std::uint8_t>(frame.id - 0x700), frame.stamp_ns)) {
            communication_back();
        }
    }
}

void Drive::Parts::nmt_command(Nmt_command command) {
    switch (command) {
    case Nmt_command::start:
        if (nmt != Nmt_state::operational) {
            nmt = Nmt_state::operational;
            for (Tpdo &tpdo : tpdos_) {
                tpdo.restart();
            }
        }
        break;
    case Nmt_command::stop:
        nmt = Nmt_state::stopped;
        sdo_.reset();
        abort_connection(communication_lost_code);
        break;
    case Nmt_command::enter_pre_operational:
        nmt = Nmt_state::pre_operational;
        break;
    case Nmt_command::reset_node:
        enter_initialising(true);
        break;
    case Nmt_command::reset_communication:
        enter_initialising(false);
        break;
    default: // reserved: ignored
        break;
    }
    if (nmt != Nmt_state::operational) {
        for (Rpdo &rpdo : rpdos_) {
            rpdo.disarm();
        }
    }
}

void Drive::Parts::enter_initialising(bool node) {
    nmt = Nmt_state::initialising;
    boot_due_ns_ = scheduler.now_ns() + std::llround((node ? config.boot_ms : communication_reset_ms) * ns_per_ms);
    sdo_.reset();
    if (node) {
        dictionary_.reset(0x0000, 0xFFFF);
        axis.power_up();
    } else {
        abort_connection(communication_lost_code);
        dictionary_.reset(0x1000, 0x1FFF);
    }
    emergency_.forget();
    communication_lost_ = sync_length_wrong_ = pdo_length_wrong_ = false;
    refresh_communication();
    refresh_pdos();
}

void Drive::Parts::on_sync(const gn_can_frame &frame) {
    ++counters.syncs;
    if (nmt != Nmt_state::operational) {
        return;
    }
    if (skip_sync) {
        skip_sync = false;
        return;
    }
    // With a counter overflow value (0x1019) SYNC carries its counter, without it is empty.
    const bool wrong = frame.length != (sync_overflow_.value != 0 ? 1 : 0);
    if (wrong && !sync_length_wrong_) {
        emergency(emcy::sync_length, frame.length);
    }
    sync_length_wrong_ = wrong;
    bool taken = false;
    for (Rpdo &rpdo : rpdos_) {
        taken = rpdo.take_over() || taken;
    }
    if (taken) {
        commanded();
    }
    axis.sync(frame.stamp_ns);

    const std::uint8_t counter = frame.length == 1 ? frame.data[0] : 0;
    bool any = false;
    for (std::size_t k = 0; k < tpdos_.size(); ++k) {
        tpdo_due_[k] = tpdos_[k].due_at_sync(counter);
        any = any || tpdo_due_[k];
    }
    const std::int64_t latch_ns = frame.stamp_ns + std::llround(config.latch_delay_us * ns_per_us);
    const std::int64_t send_ns =
        std::max(latch_ns, frame.stamp_ns) + std::llround(config.tpdo_processing_us * ns_per_us);
    // After the synchronous window (0x1007) a synchronous PDO must not be sent.
    const std::int64_t window_ns = sync_window_us_.value * 1000;
    if (any && (window_ns == 0 || send_ns <= frame.stamp_ns + window_ns)) {
        scheduler.at(send_ns, [this, latch_ns] { send_due_pdos(latch_ns); });
    }
}

void Drive::Parts::send_due_pdos(std::int64_t latch_ns) {
    if (nmt != Nmt_state::operational) {
        return;
    }
    axis.latch(latch_ns);
    for (std::size_t k = 0; k < tpdos_.size(); ++k) {
        if (tpdo_due_[k]) {
            tpdo_due_[k] = false;
            send_tpdo(tpdos_[k]);
        }
    }
}

void Drive::Parts::send_tpdo(Tpdo &tpdo) {
    ++counters.tpdos;
    transmit(tpdo.pack(scheduler.now_ns()));
}

void Drive::Parts::on_rpdo(Rpdo &rpdo, const gn_can_frame &frame) {
    ++counters.rpdos;
    const Rpdo_result result = rpdo.receive(frame);
    const bool wrong = result == Rpdo_result::too_short || result == Rpdo_result::too_long;
    if (wrong && !pdo_length_wrong_) {
        emergency(result == Rpdo_result::too_short ? emcy::pdo_too_short : emcy::pdo_too_long, frame.length);
    }
    pdo_length_wrong_ = wrong;
    if (result == Rpdo_result::too_short) {
        return;
    }
    if (communication_lost_) {
        communication_back();
    }
    if (!rpdo.synchronous()) {
        commanded();
    }
}

void Drive::Parts::commanded() {
    if (axis.command() && emergency_.any()) {
        transmit(emergency_.clear());
    }
}

void Drive::Parts::on_sdo(const gn_can_frame &frame) {
    if (nmt == Nmt_state::stopped || frame.length != 8) {
        return;
    }
    ++counters.sdo_requests;
    Sdo_server::Message request{};
    std::copy_n(frame.data, request.size(), request.begin());
    if (const auto message = sdo_.answer(request, scheduler.now_ns())) {
        scheduler.after(std::llround(config.sdo_response_us * ns_per_us),
                        [this, answer = *message] { send_sdo(answer); });
    }
    counters.sdo_aborts = sdo_.aborts();
}

void Drive::Parts::send_sdo(const Sdo_server::Message &message) {
    if (nmt == Nmt_state::stopped || nmt == Nmt_state::initialising) {
        return;
    }
    gn_can_frame frame{};
    frame.id = 0x580U + config.node;
    frame.length = 8;
    std::copy(message.begin(), message.end(), frame.data);
    transmit(frame);
}

} // namespace gonio::sim
