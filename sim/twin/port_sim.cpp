// port_sim.cpp: the simulated port: queues between devices and core, wake-ups with jitter, and the clients' frames
// looked over.
#include "port_sim.hpp"

#include <algorithm>
#include <cmath>

#include <pb_decode.h>

extern "C" {
#include "motion.h"
#include "port.h"
#include "shared.h"
#include "stream.h"
}

namespace gonio::sim {
namespace {

constexpr std::uint32_t sync_id = 0x080;
constexpr std::uint64_t first_session = 1;

Port_sim &self(void *context) {
    return *static_cast<Port_sim *>(context);
}

} // namespace

Port_sim::Port_sim(Scheduler &scheduler, Can_bus &bus, Board &board, Carrier &carrier, const Timing &timing,
                   std::uint64_t seed)
    : scheduler_(scheduler), bus_(bus), board_(board), carrier_(carrier), timing_(timing),
      jitter_(seed, Stream::sync_jitter), echo_latency_(seed, Stream::echo_latency), node_(bus.attach(*this)),
      port_(std::make_unique<gn_port>()), shared_(std::make_unique<gn_shared>()) {
    fill_can_edge();
    fill_rest();
    gn_shared_init(shared_.get());
    motion_ = gn_motion_init(port_.get(), shared_.get());
    stream_ = gn_stream_init(port_.get(), shared_.get(), "twin", first_session);
    scheduler_.after(0, [this] { run(true, true); });
}

Port_sim::~Port_sim() = default;

void Port_sim::on_frame(const gn_can_frame &frame) {
    // Own-message reception is filtered to SYNC, as on the real port.
    if (frame.own_echo && frame.id != sync_id) {
        return;
    }
    if (timing_.echo_latency_us <= 0.0) {
        receive(frame);
        return;
    }
    gn_can_frame late = frame;
    std::int64_t const latency_ns = std::llround(1e3 * echo_latency_.exponential(++received_, timing_.echo_latency_us));
    late.stamp_ns = std::max(frame.stamp_ns + latency_ns, last_stamp_ns_ + 1);
    last_stamp_ns_ = late.stamp_ns;
    scheduler_.at(late.stamp_ns, [this, late] { receive(late); });
}

void Port_sim::receive(const gn_can_frame &frame) {
    frames_.push_back(frame);
    run(true, false);
}

void Port_sim::on_edge(const gn_edge &edge) {
    edges_.push_back(edge);
    run(true, false);
}

void Port_sim::on_line(std::uint32_t line, bool level) {
    on_edge({line, ++line_numbers_.at(line), level, scheduler_.now_ns()});
}

void Port_sim::on_packet() {
    run(false, true);
}

void Port_sim::on_link() {
    run(false, true);
}

// Motion first, then stream; motion once more if stream had something for it.
void Port_sim::run(bool motion, bool stream) {
    motion_wanted_ = motion_wanted_ || motion;
    stream_wanted_ = stream_wanted_ || stream;
    if (running_) {
        return;
    }
    running_ = true;
    std::int64_t const now_ns = scheduler_.now_ns();
    while (motion_wanted_ || stream_wanted_) {
        if (motion_wanted_) {
            motion_wanted_ = false;
            motion_due_ns_ = gn_motion_process(motion_, now_ns);
            stream_wanted_ = stream_wanted_ || gn_ring_fill(&shared_->notices) > 0;
        }
        if (stream_wanted_) {
            stream_wanted_ = false;
            std::uint32_t const commands = shared_->commands.write;
            std::uint32_t const knots = shared_->knots.write;
            std::uint32_t const stops = shared_->stop_requested;
            stream_due_ns_ = gn_stream_process(stream_, now_ns);
            motion_wanted_ = motion_wanted_ || shared_->commands.write != commands || shared_->knots.write != knots ||
                             shared_->stop_requested != stops;
        }
    }
    running_ = false;
    arm_motion();
    arm_stream();
}

void Port_sim::arm_motion() {
    if (motion_due_ns_ == GN_NEVER_NS || motion_due_ns_ == armed_due_ns_) {
        return;
    }
    armed_due_ns_ = motion_due_ns_;
    std::int64_t const jitter_ns = std::llround(1e3 * timing_.sync_jitter_us * jitter_.uniform(++wakes_));
    wake_motion(std::max(motion_due_ns_, scheduler_.now_ns()) + jitter_ns);
}

void Port_sim::wake_motion(std::int64_t time_ns) {
    motion_wake_ns_ = time_ns;
    scheduler_.at(time_ns, [this, time_ns] {
        if (time_ns == motion_wake_ns_) {
            motion_wake_ns_ = INT64_MAX;
            armed_due_ns_ = -1;
            run(true, false);
        }
    });
}

void Port_sim::arm_stream() {
    if (stream_due_ns_ != GN_NEVER_NS && stream_due_ns_ < stream_wake_ns_) {
        wake_stream(stream_due_ns_);
    }
}

void Port_sim::wake_stream(std::int64_t time_ns) {
    stream_wake_ns_ = time_ns;
    scheduler_.at(time_ns, [this, time_ns] {
        if (time_ns != stream_wake_ns_) {
            return;
        }
        stream_wake_ns_ = INT64_MAX;
        // It may have run since, for another reason, and set itself a later time.
        if (stream_due_ns_ <= scheduler_.now_ns()) {
            run(false, true);
        } else {
            arm_stream();
        }
    });
}

void Port_sim::fill_can_edge() {
    port_->can.context = this;
    port_->can.send = [](void *context, const gn_can_frame *frame) {
        self(context).bus_.send(self(context).node_, *frame);
        return 0;
    };
    port_->can.receive = [](void *context, gn_can_frame *frame) {
        auto &frames = self(context).frames_;
        if (frames.empty()) {
            return 0;
        }
        *frame = frames.front();
        frames.pop_front();
        return 1;
    };
    port_->can.status = [](void *, gn_can_status *status) { *status = {}; };
    port_->edge.context = this;
    port_->edge.receive = [](void *context, gn_edge *edge) {
        auto &edges = self(context).edges_;
        if (edges.empty()) {
            return 0;
        }
        *edge = edges.front();
        edges.pop_front();
        return 1;
    };
    port_->edge.level = [](void *context, std::uint32_t line) { return self(context).board_.line_level(line); };
}

void Port_sim::fill_rest() {
    port_->out.context = this;
    port_->out.set = [](void *context, std::uint32_t output, bool on) { self(context).board_.set_output(output, on); };
    port_->out.pulse_watchdog = [](void *context) { self(context).board_.pulse_watchdog(); };
    port_->out.operator_done = [](void *context, std::uint32_t action) { self(context).board_.operator_done(action); };
    port_->digitiser.context = this;
    port_->digitiser.start = [](void *context, std::uint32_t period_us, std::uint32_t samples_per_strobe) {
        return self(context).board_.digitiser_start(period_us, samples_per_strobe) ? 0 : -1;
    };
    port_->digitiser.stop = [](void *context) { self(context).board_.digitiser_stop(); };
    port_->digitiser.read = [](void *context, std::uint8_t *buffer, std::size_t capacity) {
        return self(context).board_.digitiser_read(buffer, capacity);
    };
    port_->link.context = this;
    port_->link.read = [](void *context, std::uint32_t client, std::uint8_t *buffer, std::size_t capacity) {
        return self(context).link_read(client, buffer, capacity);
    };
    port_->link.write = [](void *context, std::uint32_t client, const std::uint8_t *bytes, std::size_t length) {
        return self(context).link_write(client, bytes, length);
    };
    port_->link.close = [](void *context, std::uint32_t client) {
        self(context).carrier_.close(client);
        self(context).sent_.at(client).reset();
    };
    port_->log.context = this;
    port_->log.write = [](void *context, gn_log_level level, const char *text) {
        self(context).board_.log(static_cast<int>(level), text);
    };
}

int Port_sim::link_read(std::uint32_t client, std::uint8_t *buffer, std::size_t capacity) {
    int const length = carrier_.read(client, buffer, capacity);
    if (length < 0) {
        sent_.at(client).reset();
    }
    return length;
}

int Port_sim::link_write(std::uint32_t client, const std::uint8_t *bytes, std::size_t length) {
    int const taken = carrier_.write(client, bytes, length);
    if (taken <= 0) {
        return taken;
    }
    auto const found = [&](const gn_frame_header &header, const std::uint8_t *payload) {
        carrier_.frame_sent(client, header.sequence, scheduler_.now_ns());
        if (header.kind == GN_FRAME_EVENT) {
            gonio_Event event = gonio_Event_init_zero;
            pb_istream_t stream = pb_istream_from_buffer(payload, header.length);
            if (pb_decode(&stream, gonio_Event_fields, &event)) {
                board_.told(event);
            }
        }
    };
    sent_.at(client).feed(bytes, static_cast<std::size_t>(taken), found);
    return taken;
}

} // namespace gonio::sim
