// bench_host.hpp: a host in the twin's own process, keeping the rule of virtual time.
#pragma once

#include <cstdint>
#include <vector>

#include "bench_dialogue.hpp"
#include "carrier.hpp"

namespace gonio::sim {

class World;

class Bench_host final : public Carrier {
public:
    // The flight lasts as long as `samples` samples.
    Bench_host(const Instrument &instrument, std::uint64_t samples);
    // Sees every SAMPLES and POSES frame.
    void watch_blocks(std::function<void(const gn_frame_header &header, const std::uint8_t *payload)> watcher) {
        dialogue_.on_block = std::move(watcher);
    }
    // To be called once, before the world's clock starts.
    void connect(World &world);

    int read(std::uint32_t client, std::uint8_t *buffer, std::size_t capacity) override;
    int write(std::uint32_t client, const std::uint8_t *bytes, std::size_t length) override;
    void close(std::uint32_t client) override;
    void frame_sent(std::uint32_t, std::uint32_t, std::int64_t) override {}
    void silence_host() override { connected_ = false; }

    [[nodiscard]] bool finished() const { return dialogue_.finished(); }
    [[nodiscard]] const Bench_result &result() const { return dialogue_.result(); }

private:
    void answer();

    Bench_dialogue dialogue_;
    World *world_ = nullptr;
    bool connected_ = true;
    std::vector<std::uint8_t> to_firmware_;
    std::size_t read_from_ = 0;
    std::vector<std::uint8_t> from_firmware_;
    bool answer_pending_ = false;
};

} // namespace gonio::sim
