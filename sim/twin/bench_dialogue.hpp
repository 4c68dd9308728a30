// bench_dialogue.hpp: what a host says to fly a path, and to whom it listens: sets the instrument up, homes it, flies.
// Whoever carries the bytes (Bench_host in virtual time, gonio-bench-host over TCP) feeds it.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "frame_scanner.hpp"
#include "gonio.pb.h"
#include "instrument.hpp"

namespace gonio::sim {

// What came back.
struct Bench_result {
    std::uint64_t samples = 0;
    std::uint64_t poses = 0;
    std::uint64_t poses_valid = 0; // all four axes
    std::uint64_t unsettled_blocks = 0;
    std::uint64_t payload_hash = 0xCBF29CE484222325U; // FNV-1a over the payloads of all SAMPLES and POSES frames
    std::uint64_t frames = 0;
    std::int64_t flight_start_ns = 0;
    std::uint64_t samples_before_flight = 0;
    std::uint64_t flight_samples = 0;
    std::int64_t end_ns = 0;
    gonio_Counters counters = gonio_Counters_init_zero;
    std::map<int, gonio_Latency> latency; // by thread
    std::string trouble;                  // empty: all went well
    bool finished = false;
};

class Bench_dialogue {
public:
    // Frames for the firmware.
    using Say = std::function<void(const std::vector<std::uint8_t> &frame)>;

    // The flight lasts as long as `samples` samples.
    Bench_dialogue(const Instrument &instrument, std::uint64_t samples, Say say);
    // Sees every SAMPLES and POSES frame.
    std::function<void(const gn_frame_header &header, const std::uint8_t *payload)> on_block;

    // HELLO; everything else follows from what is heard.
    void begin();
    void hear(const std::uint8_t *bytes, std::size_t length);
    // An empty frame, IDLE or ALIVE, that acknowledges what was heard.
    void say_empty(std::uint32_t kind) { send(kind, nullptr, 0); }
    // The connection is gone.
    void lost(const std::string &why) { fail(why); }

    [[nodiscard]] bool finished() const { return result_.finished || !result_.trouble.empty(); }
    [[nodiscard]] const Bench_result &result() const { return result_; }

private:
    void handle(const gn_frame_header &header, const std::uint8_t *payload);
    void on_event(const gonio_Event &event);
    void on_reply(const gonio_Reply &reply);
    void take_block(const gn_frame_header &header, const std::uint8_t *payload);
    void on_path(const gonio_PathState &path, std::int64_t time_ns);
    void plan_setup();
    void next_step();
    void send(std::uint32_t kind, const std::uint8_t *payload, std::size_t length);
    void send_knots(std::uint32_t credit);
    void fail(const std::string &why);

    Instrument instrument_;
    std::uint64_t wanted_samples_;
    Say say_;
    Frame_scanner scanner_;
    std::uint32_t last_sequence_ = 0;
    std::uint32_t own_sequence_ = 0;
    std::uint32_t next_request_ = 1;
    std::deque<gonio_Request> steps_;
    std::uint32_t waiting_for_ = 0; // request id, 0: none
    std::uint32_t path_id_ = 0;     // being flown, 0: none
    std::vector<gn_knot> knots_;
    std::size_t knots_sent_ = 0;
    std::array<double, axis_count> position_counts_{};
    bool clock_locked_ = false;
    Bench_result result_;
};

} // namespace gonio::sim
