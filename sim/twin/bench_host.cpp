// bench_host.cpp: carries the dialogue's bytes within the process.
#include "bench_host.hpp"

#include <algorithm>
#include <cstring>

#include "world.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t answer_ns = 1000000; // as between processes

} // namespace

Bench_host::Bench_host(const Instrument &instrument, std::uint64_t samples)
    : dialogue_(instrument, samples, [this](const std::vector<std::uint8_t> &frame) {
          to_firmware_.insert(to_firmware_.end(), frame.begin(), frame.end());
      }) {}

void Bench_host::connect(World &world) {
    world_ = &world;
    dialogue_.begin();
    world.scheduler().after(0, [this] { world_->link_changed(); });
}

int Bench_host::read(std::uint32_t client, std::uint8_t *buffer, std::size_t capacity) {
    if (client != 0 || !connected_) {
        return -1;
    }
    std::size_t const length = std::min(capacity, to_firmware_.size() - read_from_);
    std::memcpy(buffer, to_firmware_.data() + read_from_, length);
    read_from_ += length;
    if (read_from_ == to_firmware_.size()) {
        to_firmware_.clear();
        read_from_ = 0;
    }
    return static_cast<int>(length);
}

int Bench_host::write(std::uint32_t client, const std::uint8_t *bytes, std::size_t length) {
    if (client != 0 || !connected_) {
        return -1;
    }
    from_firmware_.insert(from_firmware_.end(), bytes, bytes + length);
    if (!answer_pending_) {
        answer_pending_ = true;
        world_->scheduler().after(answer_ns, [this] { answer(); });
    }
    return static_cast<int>(length);
}

void Bench_host::close(std::uint32_t client) {
    if (client == 0) {
        dialogue_.lost("the firmware closed the link");
        connected_ = false;
    }
}

void Bench_host::answer() {
    answer_pending_ = false;
    std::vector<std::uint8_t> const bytes = std::move(from_firmware_);
    from_firmware_.clear();
    dialogue_.hear(bytes.data(), bytes.size());
    dialogue_.say_empty(GN_FRAME_IDLE);
    world_->link_changed();
}

} // namespace gonio::sim
