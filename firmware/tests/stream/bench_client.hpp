// bench_client.hpp: the stream thread on a bench: links in memory, a scripted digitiser, and host clients that speak
// frames.
#ifndef GONIO_TEST_BENCH_CLIENT_HPP
#define GONIO_TEST_BENCH_CLIENT_HPP

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "../base/no_malloc.hpp"
#include "gonio.pb.h"
#include "pb_decode.h"
#include "pb_encode.h"

extern "C" {
#include "frame.h"
#include "stream.h"
}

namespace gonio::test {

using Bytes = std::vector<std::uint8_t>;

struct Frame {
    gn_frame_header header{};
    Bytes payload;

    template <typename Message> Message as(const pb_msgdesc_t *fields) const {
        Message message{};
        pb_istream_t stream = pb_istream_from_buffer(payload.data(), payload.size());
        if (!pb_decode(&stream, fields, &message)) {
            throw std::runtime_error(PB_GET_ERROR(&stream));
        }
        return message;
    }
    gonio_Hello hello() const { return as<gonio_Hello>(gonio_Hello_fields); }
    gonio_Reply reply() const { return as<gonio_Reply>(gonio_Reply_fields); }
    gonio_Event event() const { return as<gonio_Event>(gonio_Event_fields); }
    template <typename Record> Record record(std::size_t offset = 0) const {
        Record record{};
        std::memcpy(&record, payload.data() + offset, sizeof record);
        return record;
    }
};

// One byte stream of the link, seen from both ends.
struct Wire {
    bool connected = false;
    std::deque<std::uint8_t> to_firmware;
    Bytes to_host;
    std::size_t room = SIZE_MAX; // bytes that the carrier takes per write
};

class Bench {
public:
    static constexpr std::uint64_t session_id = 0x1000;
    std::array<Wire, GN_LINK_CLIENTS> wires;
    std::deque<Bytes> packets;
    bool digitiser_there = true;
    bool digitising = false;
    std::vector<std::string> log;
    std::unique_ptr<gn_shared> shared = std::make_unique<gn_shared>();
    std::int64_t now_ns = 1000000000;

    Bench() {
        gn_shared_init(shared.get());
        port.link = {this, read, write, close};
        port.digitiser = {this, start, stop, read_packet};
        port.log = {this, write_log};
        stream = gn_stream_init(&port, shared.get(), "bench", session_id);
    }
    Bench(const Bench &) = delete;
    Bench &operator=(const Bench &) = delete;

    void process(std::int64_t step_ns = 1000000) {
        now_ns += step_ns;
        In_core const core;
        gn_stream_process(stream, now_ns);
    }
    void connect(std::uint32_t client) { wires[client] = Wire{.connected = true, .to_firmware = {}, .to_host = {}}; }

private:
    gn_port port{};
    gn_stream *stream = nullptr;

    static Bench &self(void *context) { return *static_cast<Bench *>(context); }
    static int read(void *context, std::uint32_t client, std::uint8_t *buffer, std::size_t capacity) {
        In_port const port_called;
        Wire &wire = self(context).wires[client];
        if (!wire.connected) {
            return -1;
        }
        std::size_t const length = std::min(capacity, wire.to_firmware.size());
        std::copy_n(wire.to_firmware.begin(), length, buffer);
        wire.to_firmware.erase(wire.to_firmware.begin(),
                               wire.to_firmware.begin() + static_cast<std::ptrdiff_t>(length));
        return static_cast<int>(length);
    }
    static int write(void *context, std::uint32_t client, const std::uint8_t *bytes, std::size_t length) {
        In_port const port_called;
        Wire &wire = self(context).wires[client];
        if (!wire.connected) {
            return -1;
        }
        std::size_t const taken = std::min(length, wire.room);
        wire.to_host.insert(wire.to_host.end(), bytes, bytes + taken);
        return static_cast<int>(taken);
    }
    static void close(void *context, std::uint32_t client) { self(context).wires[client].connected = false; }
    static int start(void *context, std::uint32_t, std::uint32_t) {
        self(context).digitising = self(context).digitiser_there;
        return self(context).digitising ? 0 : -1;
    }
    static void stop(void *context) { self(context).digitising = false; }
    static int read_packet(void *context, std::uint8_t *buffer, std::size_t capacity) {
        In_port const port_called;
        Bench &bench = self(context);
        if (!bench.digitiser_there) {
            return -1;
        }
        if (bench.packets.empty()) {
            return 0;
        }
        Bytes const packet = bench.packets.front();
        bench.packets.pop_front();
        std::size_t const length = std::min(capacity, packet.size());
        std::copy_n(packet.begin(), length, buffer);
        return static_cast<int>(length);
    }
    static void write_log(void *context, gn_log_level, const char *text) {
        In_port const port_called;
        self(context).log.emplace_back(text);
    }
};

// A host on one of the bench's wires.
class Client {
public:
    std::uint32_t sequence = 0;     // last numbered frame sent
    std::uint32_t acknowledged = 0; // last numbered frame received

    Client(Bench &bench, std::uint32_t number) : bench_(bench), number_(number) { bench_.connect(number_); }

    Wire &wire() { return bench_.wires[number_]; }
    void raw(const Bytes &bytes) { wire().to_firmware.insert(wire().to_firmware.end(), bytes.begin(), bytes.end()); }

    Bytes sealed(std::uint32_t kind, std::uint32_t number, const Bytes &payload) const {
        Bytes bytes(GN_FRAME_HEADER_SIZE);
        bytes.insert(bytes.end(), payload.begin(), payload.end());
        gn_frame_begin(bytes.data(), kind, number, static_cast<std::uint32_t>(payload.size()));
        gn_frame_seal(bytes.data(), acknowledged);
        return bytes;
    }
    template <typename Message> static Bytes encoded(const pb_msgdesc_t *fields, const Message &message) {
        Bytes bytes(2048);
        pb_ostream_t stream = pb_ostream_from_buffer(bytes.data(), bytes.size());
        if (!pb_encode(&stream, fields, &message)) {
            throw std::runtime_error(PB_GET_ERROR(&stream));
        }
        bytes.resize(stream.bytes_written);
        return bytes;
    }
    void hello(gonio_Role role, std::uint64_t session = 0, std::uint32_t last_sequence = 0,
               std::uint64_t schema_hash = GN_SCHEMA_HASH) {
        gonio_Hello message = gonio_Hello_init_zero;
        message.schema_hash = schema_hash;
        message.role = role;
        message.session_id = session;
        message.last_sequence = last_sequence;
        raw(sealed(GN_FRAME_HELLO, 0, encoded(gonio_Hello_fields, message)));
    }
    void request(const gonio_Request &message) {
        raw(sealed(GN_FRAME_REQUEST, ++sequence, encoded(gonio_Request_fields, message)));
    }
    void request(std::uint32_t id, pb_size_t body) {
        gonio_Request message = gonio_Request_init_zero;
        message.id = id;
        message.which_body = body;
        request(message);
    }
    void acquire(std::uint32_t id, bool on) {
        gonio_Request message = gonio_Request_init_zero;
        message.id = id;
        message.which_body = gonio_Request_acquire_tag;
        message.body.acquire.on = on;
        request(message);
    }
    void knots(std::uint32_t path_id, std::uint32_t first, std::uint32_t count) {
        gn_knot_block const block = {path_id, first, count, 0};
        Bytes payload(sizeof block + std::size_t{count} * GN_KNOT_SIZE);
        std::memcpy(payload.data(), &block, sizeof block);
        for (std::uint32_t i = 0; i < count; ++i) {
            std::int64_t const time_ns = 1000 * std::int64_t{first + i};
            std::memcpy(payload.data() + sizeof block + std::size_t{i} * GN_KNOT_SIZE, &time_ns, sizeof time_ns);
        }
        raw(sealed(GN_FRAME_KNOTS, ++sequence, payload));
    }
    void alive() { raw(sealed(GN_FRAME_ALIVE, 0, {})); }

    // All frames that have come; throws where the bytes are no frames.
    std::vector<Frame> frames() {
        std::vector<Frame> frames;
        std::size_t at = 0;
        gn_frame_decoder_reset(&decoder_);
        while (at < wire().to_host.size()) {
            std::size_t taken = 0;
            auto const progress =
                gn_frame_decode(&decoder_, wire().to_host.data() + at, wire().to_host.size() - at, &taken);
            at += taken;
            if (progress == GN_FRAME_REFUSED) {
                throw std::runtime_error(gn_frame_error_text(decoder_.error));
            }
            if (progress == GN_FRAME_COMPLETE) {
                frames.push_back({gn_frame_header_at(decoder_.bytes),
                                  Bytes(decoder_.bytes + GN_FRAME_HEADER_SIZE, decoder_.bytes + decoder_.filled)});
                acknowledged = std::max(acknowledged, std::uint32_t{frames.back().header.sequence});
            }
        }
        wire().to_host.clear();
        return frames;
    }
    std::vector<Frame> frames_of(std::uint32_t kind) {
        std::vector<Frame> chosen;
        for (auto &frame : frames()) {
            if (frame.header.kind == kind) {
                chosen.push_back(std::move(frame));
            }
        }
        return chosen;
    }

private:
    Bench &bench_;
    std::uint32_t number_;
    gn_frame_decoder decoder_{};
};

} // namespace gonio::test

#endif
