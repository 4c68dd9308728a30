// nmt.cpp: heartbeat producer and consumer.
#include "nmt.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t ns_per_ms = 1'000'000;
constexpr std::uint16_t consumer_index = 0x1016;

std::uint8_t producer_of(std::int64_t value) {
    return static_cast<std::uint8_t>(value >> 16U);
}

} // namespace

Heartbeat_producer::Heartbeat_producer(Object_dictionary &dictionary, std::uint8_t node)
    : period_ms_(dictionary.at(0x1017)), node_(node) {}

bool Heartbeat_producer::due(std::int64_t now_ns) {
    if (period_ms_.value == 0 || now_ns - last_ns_ < period_ms_.value * ns_per_ms) {
        return false;
    }
    last_ns_ = now_ns;
    return true;
}

gn_can_frame Heartbeat_producer::frame(Nmt_state state) const {
    gn_can_frame frame{};
    frame.id = 0x700U + node_;
    frame.length = 1;
    frame.data[0] = static_cast<std::uint8_t>(state);
    return frame;
}

Heartbeat_consumer::Heartbeat_consumer(Object_dictionary &dictionary) : dictionary_(dictionary) {
    refresh();
}

std::uint32_t Heartbeat_consumer::check_write(Object_dictionary &dictionary, const Od_entry &entry,
                                              std::int64_t value) {
    if (entry.subindex == 0 || (value & 0xFFFF) == 0 || producer_of(value) == 0) {
        return abort_code::none;
    }
    const std::int64_t count = dictionary.at(consumer_index, 0).value;
    for (std::int64_t k = 1; k <= count; ++k) {
        const Od_entry &other = dictionary.at(consumer_index, static_cast<std::uint8_t>(k));
        if (other.subindex != entry.subindex && (other.value & 0xFFFF) != 0 &&
            producer_of(other.value) == producer_of(value)) {
            return abort_code::parameter_incompatible;
        }
    }
    return abort_code::none;
}

void Heartbeat_consumer::refresh() {
    for (std::size_t k = 0; k < watched_.size(); ++k) {
        const Od_entry *entry = dictionary_.find(consumer_index, static_cast<std::uint8_t>(k + 1));
        const std::int64_t value = entry != nullptr ? entry->value : 0;
        watched_[k] = Watched{};
        watched_[k].producer = producer_of(value);
        watched_[k].timeout_ns = (value & 0xFFFF) * ns_per_ms;
    }
}

bool Heartbeat_consumer::receive(std::uint8_t producer, std::int64_t now_ns) {
    bool returned = false;
    for (Watched &watched : watched_) {
        if (watched.producer == producer && watched.timeout_ns != 0) {
            returned = returned || watched.lost;
            watched.last_ns = now_ns;
            watched.alive = true;
            watched.lost = false;
        }
    }
    return returned;
}

std::uint8_t Heartbeat_consumer::lost(std::int64_t now_ns) {
    for (Watched &watched : watched_) {
        if (watched.alive && now_ns - watched.last_ns > watched.timeout_ns) {
            watched.alive = false;
            watched.lost = true;
            return watched.producer;
        }
    }
    return 0;
}

} // namespace gonio::sim
