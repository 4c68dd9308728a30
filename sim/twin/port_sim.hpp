// port_sim.hpp: the firmware core on the twin: every seam of firmware/port, and its two entry points called in a fixed
// order.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "can_bus.hpp"
#include "carrier.hpp"
#include "edge.h"
#include "frame_scanner.hpp"
#include "gonio.pb.h"
#include "link.h"
#include "random.hpp"
#include "scenario.hpp"
#include "scheduler.hpp"

struct gn_motion;
struct gn_port;
struct gn_shared;
struct gn_stream;

namespace gonio::sim {

// The controller board around the core, and who wants to know what the firmware says.
class Board {
public:
    virtual ~Board() = default;
    virtual void set_output(std::uint32_t output, bool on) = 0;
    virtual void pulse_watchdog() = 0;
    virtual void operator_done(std::uint32_t action) = 0;
    virtual bool digitiser_start(std::uint32_t sample_period_us, std::uint32_t samples_per_strobe) = 0;
    virtual void digitiser_stop() = 0;
    virtual int digitiser_read(std::uint8_t *buffer, std::size_t capacity) = 0;
    [[nodiscard]] virtual bool line_level(std::uint32_t line) const = 0;
    virtual void log(int level, const std::string &text) = 0;
    // An event that the firmware sent to its driver.
    virtual void told(const gonio_Event &event) = 0;
};

// The core has one static instance: one Port_sim at a time.
class Port_sim final : public Can_node {
public:
    Port_sim(Scheduler &scheduler, Can_bus &bus, Board &board, Carrier &carrier, const Timing &timing,
             std::uint64_t seed);
    ~Port_sim() override;
    Port_sim(const Port_sim &) = delete;
    Port_sim &operator=(const Port_sim &) = delete;
    Port_sim(Port_sim &&) = delete;
    Port_sim &operator=(Port_sim &&) = delete;

    void on_frame(const gn_can_frame &frame) override;
    void on_edge(const gn_edge &edge);
    // A line other than the strobe changes.
    void on_line(std::uint32_t line, bool level);
    void on_packet();
    // Bytes from a client, or a client came or went.
    void on_link();

private:
    void receive(const gn_can_frame &frame);
    void run(bool motion, bool stream);
    void arm_motion();
    void arm_stream();
    void wake_motion(std::int64_t time_ns);
    void wake_stream(std::int64_t time_ns);
    void fill_can_edge();
    void fill_rest();
    int link_read(std::uint32_t client, std::uint8_t *buffer, std::size_t capacity);
    int link_write(std::uint32_t client, const std::uint8_t *bytes, std::size_t length);

    Scheduler &scheduler_;
    Can_bus &bus_;
    Board &board_;
    Carrier &carrier_;
    Timing timing_;
    Random jitter_;
    Random echo_latency_;
    int node_ = 0;
    std::unique_ptr<gn_port> port_;
    std::unique_ptr<gn_shared> shared_;
    gn_motion *motion_ = nullptr;
    gn_stream *stream_ = nullptr;
    std::deque<gn_can_frame> frames_;
    std::deque<gn_edge> edges_;
    std::array<std::uint32_t, GN_LINE_COUNT> line_numbers_{};
    std::array<Frame_scanner, GN_LINK_CLIENTS> sent_;
    bool running_ = false;
    bool motion_wanted_ = false;
    bool stream_wanted_ = false;
    std::int64_t motion_due_ns_ = 0;
    std::int64_t stream_due_ns_ = 0;
    std::int64_t armed_due_ns_ = -1; // the due time for which motion_wake_ns_ was drawn
    std::int64_t motion_wake_ns_ = INT64_MAX;
    std::int64_t stream_wake_ns_ = INT64_MAX;
    std::uint64_t wakes_ = 0;
    std::uint64_t received_ = 0;
    std::int64_t last_stamp_ns_ = 0;
};

} // namespace gonio::sim
