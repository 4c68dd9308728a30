// pdo.cpp: reception and transmission of process data.
#include "pdo.hpp"

#include <algorithm>

namespace gonio::sim {
namespace {

constexpr std::int64_t ns_per_ms = 1'000'000;
constexpr std::int64_t ns_per_inhibit_unit = 100'000;

std::int64_t value_or(const Od_entry *entry, std::int64_t otherwise) {
    return entry != nullptr ? entry->value : otherwise;
}

} // namespace

Pdo::Pdo(Object_dictionary &dictionary, std::uint16_t communication, std::uint16_t mapping)
    : dictionary_(dictionary), communication_(communication), mapping_(mapping) {
    refresh();
}

void Pdo::refresh() {
    const Od_entry *cob_id = dictionary_.find(communication_, 1);
    exists_ = cob_id != nullptr && (cob_id->value & 0x80000000) == 0;
    id_ = static_cast<std::uint32_t>(value_or(cob_id, 0)) & 0x7FFU;
    type_ = static_cast<unsigned>(value_or(dictionary_.find(communication_, 2), 255));
    event_timer_ns_ = value_or(dictionary_.find(communication_, 5), 0) * ns_per_ms;
    count_ = static_cast<unsigned>(std::min<std::int64_t>(value_or(dictionary_.find(mapping_, 0), 0), 8));
    bytes_ = 0;
    for (unsigned k = 0; k < count_; ++k) {
        const std::int64_t mapped = dictionary_.at(mapping_, static_cast<std::uint8_t>(k + 1)).value;
        mapped_[k].entry =
            dictionary_.find(static_cast<std::uint16_t>(mapped >> 16U), static_cast<std::uint8_t>(mapped >> 8U));
        mapped_[k].bytes = static_cast<unsigned>(mapped & 0xFF) / 8U;
        bytes_ += mapped_[k].bytes;
    }
}

Rpdo_result Rpdo::receive(const gn_can_frame &frame) {
    if (frame.length < bytes_) {
        return Rpdo_result::too_short;
    }
    armed_ = true;
    received_ns_ = frame.stamp_ns;
    std::copy_n(frame.data, 8, data_.begin());
    waiting_ = synchronous();
    if (!waiting_) {
        unpack();
    }
    if (frame.length > bytes_) {
        return Rpdo_result::too_long;
    }
    return waiting_ ? Rpdo_result::waits_for_sync : Rpdo_result::taken;
}

bool Rpdo::take_over() {
    if (!waiting_) {
        return false;
    }
    waiting_ = false;
    unpack();
    return true;
}

void Rpdo::unpack() {
    unsigned place = 0;
    for (unsigned k = 0; k < count_; ++k) {
        if (Od_entry *entry = mapped_[k].entry; entry != nullptr) {
            entry->value = value_from_bytes(&data_[place], mapped_[k].bytes, entry->is_signed);
        }
        place += mapped_[k].bytes;
    }
}

bool Rpdo::deadline_missed(std::int64_t now_ns) {
    if (!armed_ || event_timer_ns_ == 0 || now_ns - received_ns_ <= event_timer_ns_) {
        return false;
    }
    armed_ = false;
    return true;
}

Tpdo::Tpdo(Object_dictionary &dictionary, std::uint16_t communication, std::uint16_t mapping)
    : Pdo(dictionary, communication, mapping) {
    refresh();
}

void Tpdo::refresh() {
    Pdo::refresh();
    inhibit_ns_ = value_or(dictionary_.find(communication_, 3), 0) * ns_per_inhibit_unit;
    start_value_ = static_cast<unsigned>(value_or(dictionary_.find(communication_, 6), 0));
    restart();
}

void Tpdo::restart() {
    sent_ = false;
    syncs_ = 0;
    started_ = false;
}

std::array<std::uint8_t, 8> Tpdo::values() const {
    std::array<std::uint8_t, 8> data{};
    unsigned place = 0;
    for (unsigned k = 0; k < count_; ++k) {
        value_to_bytes(mapped_[k].entry->value, &data[place], mapped_[k].bytes);
        place += mapped_[k].bytes;
    }
    return data;
}

bool Tpdo::due_at_sync(std::uint8_t counter) {
    if (!exists_ || !synchronous() || bytes_ == 0) {
        return false;
    }
    if (type_ == 0) {
        return !sent_ || values() != last_;
    }
    if (!started_) {
        // With a start value the first PDO goes out at the SYNC of that count; without, after `type` SYNCs.
        started_ = start_value_ == 0 || counter == 0 || counter == start_value_;
        syncs_ = start_value_ == 0 || counter == 0 ? 0 : type_ - 1;
    }
    if (!started_ || ++syncs_ < type_) {
        return false;
    }
    syncs_ = 0;
    return true;
}

bool Tpdo::due_by_event(std::int64_t now_ns) {
    if (!exists_ || synchronous() || bytes_ == 0) {
        return false;
    }
    if (!sent_) {
        return true;
    }
    if (now_ns - sent_ns_ < inhibit_ns_) {
        return false;
    }
    return (event_timer_ns_ != 0 && now_ns - sent_ns_ >= event_timer_ns_) || values() != last_;
}

gn_can_frame Tpdo::pack(std::int64_t now_ns) {
    last_ = values();
    sent_ = true;
    sent_ns_ = now_ns;
    gn_can_frame frame{};
    frame.id = id_;
    frame.length = static_cast<std::uint8_t>(bytes_);
    std::copy(last_.begin(), last_.end(), frame.data);
    return frame;
}

} // namespace gonio::sim
