// bench_dialogue.cpp: requests one after the other, knots as there is credit, and accounts of what comes back.
#include "bench_dialogue.hpp"

#include <algorithm>
#include <cstring>

#include <pb_decode.h>
#include <pb_encode.h>

#include "bench_paths.hpp"

extern "C" {
#include "frame.h"
}

namespace gonio::sim {
namespace {

constexpr std::uint32_t move_path = 1;
constexpr std::uint32_t flight_path = 2;
constexpr std::uint32_t knots_per_frame = 32;
constexpr std::uint32_t all_axes = 0xF;

gonio_Request empty_request(pb_size_t body) {
    gonio_Request request = gonio_Request_init_zero;
    request.which_body = body;
    return request;
}

} // namespace

Bench_dialogue::Bench_dialogue(const Instrument &instrument, std::uint64_t samples, Say say)
    : instrument_(instrument), wanted_samples_(samples), say_(std::move(say)) {}

void Bench_dialogue::begin() {
    gonio_Hello hello = gonio_Hello_init_zero;
    hello.schema_hash = GN_SCHEMA_HASH;
    std::strcpy(hello.software, "gonio-twin-bench");
    hello.role = gonio_Role_ROLE_DRIVER;
    std::array<std::uint8_t, gonio_Hello_size> payload{};
    pb_ostream_t stream = pb_ostream_from_buffer(payload.data(), payload.size());
    if (!pb_encode(&stream, gonio_Hello_fields, &hello)) {
        fail("HELLO cannot be encoded");
    }
    send(GN_FRAME_HELLO, payload.data(), stream.bytes_written);
    plan_setup();
}

void Bench_dialogue::hear(const std::uint8_t *bytes, std::size_t length) {
    scanner_.feed(bytes, length,
                  [this](const gn_frame_header &header, const std::uint8_t *payload) { handle(header, payload); });
}

void Bench_dialogue::handle(const gn_frame_header &header, const std::uint8_t *payload) {
    ++result_.frames;
    if (header.sequence != 0) {
        last_sequence_ = header.sequence;
    }
    if (header.kind == GN_FRAME_SAMPLES || header.kind == GN_FRAME_POSES) {
        take_block(header, payload);
        return;
    }
    pb_istream_t stream = pb_istream_from_buffer(payload, header.length);
    if (header.kind == GN_FRAME_EVENT) {
        gonio_Event event = gonio_Event_init_zero;
        if (pb_decode(&stream, gonio_Event_fields, &event)) {
            on_event(event);
        }
    } else if (header.kind == GN_FRAME_REPLY) {
        gonio_Reply reply = gonio_Reply_init_zero;
        if (pb_decode(&stream, gonio_Reply_fields, &reply)) {
            on_reply(reply);
        }
    } else if (header.kind == GN_FRAME_HELLO) {
        gonio_Hello hello = gonio_Hello_init_zero;
        if (pb_decode(&stream, gonio_Hello_fields, &hello) && hello.refusal[0] != 0) {
            fail(hello.refusal);
        }
    }
}

void Bench_dialogue::take_block(const gn_frame_header &header, const std::uint8_t *payload) {
    for (std::uint32_t i = 0; i < header.length; ++i) {
        result_.payload_hash = (result_.payload_hash ^ payload[i]) * 0x100000001B3U;
    }
    if (on_block) {
        on_block(header, payload);
    }
    if (header.kind == GN_FRAME_SAMPLES) {
        gn_sample_block block{};
        std::memcpy(&block, payload, sizeof block);
        result_.samples += block.count;
        result_.unsettled_blocks += (block.flags & GN_SAMPLE_BLOCK_CLOCK_UNSETTLED) != 0 ? 1U : 0U;
        return;
    }
    gn_pose_block block{};
    std::memcpy(&block, payload, sizeof block);
    for (std::uint32_t i = 0; i < block.count; ++i) {
        gn_pose pose{};
        std::memcpy(&pose, payload + sizeof block + i * sizeof pose, sizeof pose);
        ++result_.poses;
        result_.poses_valid += pose.valid == all_axes ? 1U : 0U;
    }
}

void Bench_dialogue::on_event(const gonio_Event &event) {
    switch (event.which_body) {
    case gonio_Event_status_tag: {
        const gonio_Status &status = event.body.status;
        for (pb_size_t i = 0; i < std::min<pb_size_t>(status.position_counts_count, axis_count); ++i) {
            position_counts_.at(i) = status.position_counts[i];
        }
        if (status.path_id == path_id_) {
            send_knots(status.knot_credit);
        }
        clock_locked_ = status.clock_locked;
        if (waiting_for_ == 0 && path_id_ == 0) {
            next_step();
        }
        break;
    }
    case gonio_Event_fault_tag:
        fail(event.body.fault.sentence);
        break;
    case gonio_Event_done_tag:
        if (event.body.done.request_id == waiting_for_) {
            waiting_for_ = 0;
            if (event.body.done.code != gonio_ReplyCode_REPLY_OK) {
                fail(event.body.done.text);
            }
        }
        break;
    case gonio_Event_path_tag:
        on_path(event.body.path, event.time_ns);
        break;
    case gonio_Event_counters_tag:
        result_.counters = event.body.counters;
        break;
    case gonio_Event_latency_tag:
        result_.latency[event.body.latency.thread] = event.body.latency;
        break;
    default:
        break;
    }
}

void Bench_dialogue::on_path(const gonio_PathState &path, std::int64_t time_ns) {
    if (path.end == gonio_PathEnd_PATH_RUNNING) {
        result_.flight_start_ns = time_ns;
        result_.samples_before_flight = result_.samples;
        return;
    }
    if (path.end != gonio_PathEnd_PATH_FINISHED) {
        fail("path " + std::to_string(path.path_id) + " ended early (" + std::to_string(path.end) + ")");
    }
    path_id_ = 0;
    if (path.path_id == flight_path) {
        result_.end_ns = time_ns;
        result_.flight_samples = result_.samples - result_.samples_before_flight;
        result_.finished = true;
    }
}

void Bench_dialogue::on_reply(const gonio_Reply &reply) {
    if (reply.code == gonio_ReplyCode_REPLY_ACCEPTED) {
        return; // OperationDone follows
    }
    if (reply.code != gonio_ReplyCode_REPLY_OK) {
        fail(std::string("request ") + std::to_string(reply.id) + ": " + reply.text);
    }
    waiting_for_ = reply.id == waiting_for_ ? 0 : waiting_for_;
    // Configuration needs no pause between its requests.
    if (waiting_for_ == 0 && path_id_ == 0) {
        next_step();
    }
}

void Bench_dialogue::plan_setup() {
    steps_.push_back(configure_request(instrument_));
    for (std::size_t i = 0; i < axis_count; ++i) {
        steps_.push_back(axis_request(instrument_, i));
    }
    steps_.push_back(empty_request(gonio_Request_boot_tag));
    gonio_Request home = empty_request(gonio_Request_home_tag);
    home.body.home.axis_mask = all_axes;
    steps_.push_back(home);
    for (gonio_Output const output : {gonio_Output_OUTPUT_LAMP, gonio_Output_OUTPUT_SHUTTER}) {
        gonio_Request on = empty_request(gonio_Request_set_output_tag);
        on.body.set_output = {output, true};
        steps_.push_back(on);
    }
    gonio_Request acquire = empty_request(gonio_Request_acquire_tag);
    acquire.body.acquire.on = true;
    steps_.push_back(acquire);
    for (std::uint32_t const path : {move_path, flight_path}) {
        gonio_Request begin = empty_request(gonio_Request_motion_begin_tag);
        begin.body.motion_begin = {path, 0, true};
        steps_.push_back(begin);
    }
}

void Bench_dialogue::next_step() {
    if (steps_.empty() || finished()) {
        return;
    }
    gonio_Request next = steps_.front();
    if (next.which_body == gonio_Request_motion_begin_tag) {
        bool const flight = next.body.motion_begin.path_id == flight_path;
        if (flight && !clock_locked_) {
            return; // the flight's samples shall all have the fitted clock
        }
        double const duration_s = 1e-6 * instrument_.cycle.sample_period_us * static_cast<double>(wanted_samples_);
        path_id_ = next.body.motion_begin.path_id;
        knots_ = flight ? sinusoidal_flight(instrument_, duration_s) : move_to_start(instrument_, position_counts_);
        knots_sent_ = 0;
        next.body.motion_begin.knot_count = static_cast<std::uint32_t>(knots_.size());
    }
    steps_.pop_front();
    next.id = next_request_++;
    waiting_for_ = next.id;
    std::array<std::uint8_t, gonio_Request_size> payload{};
    pb_ostream_t stream = pb_ostream_from_buffer(payload.data(), payload.size());
    if (!pb_encode(&stream, gonio_Request_fields, &next)) {
        fail("a request cannot be encoded");
    }
    send(GN_FRAME_REQUEST, payload.data(), stream.bytes_written);
}

void Bench_dialogue::send_knots(std::uint32_t credit) {
    while (knots_sent_ < std::min<std::size_t>(credit, knots_.size())) {
        auto const count = static_cast<std::uint32_t>(
            std::min<std::size_t>({knots_per_frame, credit - knots_sent_, knots_.size() - knots_sent_}));
        gn_knot_block const block{path_id_, static_cast<std::uint32_t>(knots_sent_), count, 0};
        std::vector<std::uint8_t> payload(sizeof block + count * sizeof(gn_knot));
        std::memcpy(payload.data(), &block, sizeof block);
        std::memcpy(payload.data() + sizeof block, &knots_.at(knots_sent_), count * sizeof(gn_knot));
        send(GN_FRAME_KNOTS, payload.data(), payload.size());
        knots_sent_ += count;
    }
}

void Bench_dialogue::send(std::uint32_t kind, const std::uint8_t *payload, std::size_t length) {
    bool const numbered = kind == GN_FRAME_REQUEST || kind == GN_FRAME_KNOTS;
    std::vector<std::uint8_t> frame(GN_FRAME_HEADER_SIZE + length);
    if (length > 0) {
        std::memcpy(frame.data() + GN_FRAME_HEADER_SIZE, payload, length);
    }
    gn_frame_begin(frame.data(), kind, numbered ? ++own_sequence_ : 0, static_cast<std::uint32_t>(length));
    gn_frame_seal(frame.data(), last_sequence_);
    say_(frame);
}

void Bench_dialogue::fail(const std::string &why) {
    if (result_.trouble.empty()) {
        result_.trouble = why;
    }
}

} // namespace gonio::sim
