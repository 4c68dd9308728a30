// drive_access.cpp: what a drive has to say about reading and writing its objects by SDO.
#include "drive_parts.hpp"

namespace gonio::sim {

std::uint32_t Drive::Parts::before_read(Od_entry &entry) {
    if (entry.index == 0x1003) {
        return Emergency::check_history_read(dictionary_, entry);
    }
    axis.latch(scheduler.now_ns());
    return abort_code::none;
}

std::uint32_t Drive::Parts::before_write(const Od_entry &entry, std::int64_t value) {
    switch (entry.index) {
    case 0x1005: // no SYNC producer (bit 30), 11-bit identifiers only
    case 0x1014: // the same bits are reserved here
        return (value & 0x7FFFF800) != 0 ? abort_code::value_range : abort_code::none;
    case 0x1016:
        return Heartbeat_consumer::check_write(dictionary_, entry, value);
    case 0x1019: // not while SYNC has a period (CiA 301); 1 is reserved
        if (value != entry.value && dictionary_.at(0x1006).value != 0) {
            return abort_code::device_state;
        }
        return value == 1 ? abort_code::value_range : abort_code::none;
    case 0x605A: // current and voltage limit (3, 4) are not offered
        return value == 3 || value == 4 ? abort_code::value_range : abort_code::none;
    case 0x6060:
        return mode::supported(value) ? abort_code::none : abort_code::value_range;
    case 0x6098:
        return value == 0 || Homing::supports(value) ? abort_code::none : abort_code::value_range;
    default:
        return entry.index >= 0x1400 && entry.index < 0x1C00 ? check_pdo_write(dictionary_, entry, value)
                                                             : abort_code::none;
    }
}

void Drive::Parts::after_write(Od_entry &entry) {
    switch (entry.index) {
    case 0x1003: // writing 0 to the count clears the history
        dictionary_.reset(0x1003, 0x1003);
        break;
    case 0x1017:
        producer_.restart(scheduler.now_ns());
        break;
    case 0x6040:
        commanded();
        break;
    case 0x1005:
    case 0x1016:
        refresh_communication();
        break;
    default:
        if (entry.index >= 0x1400 && entry.index < 0x1C00) {
            refresh_pdos();
        }
        break;
    }
}

void Drive::Parts::refresh_communication() {
    sync_id_ = static_cast<std::uint32_t>(dictionary_.at(0x1005).value) & 0x7FFU;
    consumer_.refresh();
}

void Drive::Parts::refresh_pdos() {
    for (Rpdo &rpdo : rpdos_) {
        rpdo.refresh();
    }
    for (Tpdo &tpdo : tpdos_) {
        tpdo.refresh();
    }
}

} // namespace gonio::sim
