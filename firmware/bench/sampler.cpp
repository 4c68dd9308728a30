// sampler.cpp: how many samples per second one core takes from digitiser packets to link frames, checksums included.
// Everything that a round of the stream thread does is timed: packets, strobes and clock fit, blocks, replay ring,
// sealing, acknowledgements. The frames are then looked over, outside the timed part. JSON on standard output;
// `--frames FILE` keeps the frames, `--packets FILE` the packets, for judges and peers that are not ours.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "pb_encode.h"

extern "C" {
#include "frame.h"
#include "gonio.pb.h"
#include "port.h"
#include "shared.h"
#include "stream.h"
}

namespace {

constexpr std::uint32_t samples = 5'000'000;
constexpr std::uint32_t samples_per_packet = 250;
constexpr std::uint32_t packets = samples / samples_per_packet;
constexpr std::size_t packet_size = GN_DIGITISER_PACKET_SIZE + samples_per_packet * GN_SAMPLE_SIZE;
constexpr std::uint32_t packets_per_round = 100; // 5 ms, the stream thread's poll, of 5,000,000 samples/s
constexpr std::int64_t sample_period_ns = 1000;  // the shortest that Configure allows
constexpr std::uint32_t samples_per_strobe = 10'000;
constexpr std::int64_t start_ns = 1'000'000'000;

using Bytes = std::vector<std::uint8_t>;

Bytes make_packets() {
    Bytes bytes(packets * packet_size);
    std::uint32_t noise = 1;
    for (std::uint32_t p = 0; p < packets; ++p) {
        std::uint8_t *place = bytes.data() + p * packet_size;
        gn_digitiser_packet const header = {0x4744, static_cast<std::uint16_t>(p), p * samples_per_packet,
                                            samples_per_packet, 0};
        std::memcpy(place, &header, sizeof header);
        for (std::uint32_t i = 0; i < samples_per_packet; ++i) {
            noise = noise * 1664525U + 1013904223U;
            gn_sample const sample = {static_cast<std::int32_t>(noise) >> 8, static_cast<std::int32_t>(noise) >> 18,
                                      4'000'000, 2512, 0};
            std::memcpy(place + sizeof header + i * sizeof sample, &sample, sizeof sample);
        }
    }
    return bytes;
}

// The world around the stream thread: a digitiser whose packets come in time, a host that takes and acknowledges.
class Sampler {
public:
    Sampler() : packets_(make_packets()), from_host_(), frames_(std::size_t{samples} * GN_SAMPLE_SIZE * 11 / 10) {
        gn_shared_init(shared_.get());
        port_.link = {this, read_link, write_link, [](void *, std::uint32_t) {}};
        port_.digitiser = {this, [](void *, std::uint32_t, std::uint32_t) { return 0; }, [](void *) {}, read_packet};
        port_.log = {this, [](void *, gn_log_level, const char *text) { std::fprintf(stderr, "%s\n", text); }};
        stream_ = gn_stream_init(&port_, shared_.get(), "bench", 1);
        std::memset(frames_.data(), 1, frames_.size()); // no page is met for the first time in the timed part
    }

    double run() {
        begin();
        auto const from = std::chrono::steady_clock::now();
        for (std::uint32_t round = 0; round < packets / packets_per_round; ++round) {
            available_ += packets_per_round;
            now_ns_ = start_ns + std::int64_t{available_} * samples_per_packet * sample_period_ns;
            push_strobes();
            gn_stream_process(stream_, now_ns_);
            acknowledge();
        }
        acquire(false);
        gn_stream_process(stream_, now_ns_ + 1);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    }

    // Every frame whole and in order, every sample there once and as the digitiser sent it. Their number.
    std::uint32_t look_over() const {
        auto const decoder = std::make_unique<gn_frame_decoder>();
        gn_frame_decoder_reset(decoder.get());
        std::uint64_t next_sample = 0;
        std::uint32_t sequence = 0;
        for (std::size_t at = 0; at < written_;) {
            std::size_t taken = 0;
            if (gn_frame_decode(decoder.get(), frames_.data() + at, written_ - at, &taken) != GN_FRAME_COMPLETE) {
                throw std::runtime_error(gn_frame_error_text(decoder->error));
            }
            at += taken;
            gn_frame_header const header = gn_frame_header_at(decoder->bytes);
            if (header.sequence != 0 && header.sequence != ++sequence) {
                throw std::runtime_error("a frame is missing");
            }
            if (header.kind == GN_FRAME_SAMPLES) {
                next_sample += look_at(decoder->bytes + GN_FRAME_HEADER_SIZE, next_sample);
            }
        }
        if (next_sample != samples) {
            throw std::runtime_error("samples are missing at the end");
        }
        return sequence;
    }

    std::size_t written() const { return written_; }
    void keep(const char *name, bool the_packets) const {
        std::FILE *file = std::fopen(name, "wb");
        const std::uint8_t *bytes = the_packets ? packets_.data() : frames_.data();
        std::size_t const size = the_packets ? packets_.size() : written_;
        if (file == nullptr || std::fwrite(bytes, 1, size, file) != size || std::fclose(file) != 0) {
            throw std::runtime_error(std::string("cannot write ") + name);
        }
    }

private:
    static Sampler &self(void *context) { return *static_cast<Sampler *>(context); }
    static int read_link(void *context, std::uint32_t client, std::uint8_t *buffer, std::size_t capacity) {
        Sampler &s = self(context);
        if (client != 0) {
            return -1;
        }
        std::size_t const length = std::min(capacity, s.from_host_.size());
        std::memcpy(buffer, s.from_host_.data(), length);
        s.from_host_.erase(s.from_host_.begin(), s.from_host_.begin() + static_cast<std::ptrdiff_t>(length));
        return static_cast<int>(length);
    }
    static int write_link(void *context, std::uint32_t, const std::uint8_t *bytes, std::size_t length) {
        Sampler &s = self(context);
        if (s.written_ + length > s.frames_.size()) {
            return -1;
        }
        std::memcpy(s.frames_.data() + s.written_, bytes, length);
        s.written_ += length;
        return static_cast<int>(length);
    }
    static int read_packet(void *context, std::uint8_t *buffer, std::size_t capacity) {
        Sampler &s = self(context);
        if (s.next_packet_ == s.available_ || capacity < packet_size) {
            return 0;
        }
        std::memcpy(buffer, s.packets_.data() + s.next_packet_++ * packet_size, packet_size);
        return static_cast<int>(packet_size);
    }

    template <typename Message> void say(std::uint32_t kind, const pb_msgdesc_t *fields, const Message &message) {
        Bytes frame(GN_FRAME_HEADER_SIZE + 512);
        pb_ostream_t out = pb_ostream_from_buffer(frame.data() + GN_FRAME_HEADER_SIZE, 512);
        if (!pb_encode(&out, fields, &message)) {
            throw std::runtime_error("a request could not be encoded");
        }
        frame.resize(GN_FRAME_HEADER_SIZE + out.bytes_written);
        gn_frame_begin(frame.data(), kind, kind == GN_FRAME_HELLO ? 0 : ++host_sequence_,
                       static_cast<std::uint32_t>(out.bytes_written));
        gn_frame_seal(frame.data(), acknowledged_);
        from_host_.insert(from_host_.end(), frame.begin(), frame.end());
    }
    void acquire(bool on) {
        gonio_Request request = gonio_Request_init_zero;
        request.id = 2;
        request.which_body = gonio_Request_acquire_tag;
        request.body.acquire.on = on;
        say(GN_FRAME_REQUEST, gonio_Request_fields, request);
    }
    void begin() {
        gonio_Hello hello = gonio_Hello_init_zero;
        hello.schema_hash = GN_SCHEMA_HASH;
        hello.role = gonio_Role_ROLE_DRIVER;
        say(GN_FRAME_HELLO, gonio_Hello_fields, hello);
        gonio_Request request = gonio_Request_init_zero;
        request.id = 1;
        request.which_body = gonio_Request_configure_tag;
        request.body.configure.sample_period_us = sample_period_ns / 1000;
        request.body.configure.samples_per_strobe = samples_per_strobe;
        request.body.configure.clock_settle_ms = 2000;
        request.body.configure.edge_tolerance_percent = 25;
        say(GN_FRAME_REQUEST, gonio_Request_fields, request);
        gn_stream_process(stream_, 1);
        gn_notice notice{}; // motion accepts the configuration
        notice.is_reply = true;
        notice.as.reply.id = 1;
        gn_ring_push(&shared_->notices, &notice);
        gn_stream_process(stream_, 2);
        acquire(true);
        gn_stream_process(stream_, 3);
    }
    void push_strobes() {
        std::int64_t const strobe_ns = std::int64_t{samples_per_strobe} * sample_period_ns;
        for (; start_ns + strobes_ * strobe_ns < now_ns_; ++strobes_) {
            std::int64_t const up_ns = start_ns + strobes_ * strobe_ns;
            std::int64_t const width_ns = strobe_ns / (strobes_ % 64 == 0 ? 2 : 4);
            for (bool const rising : {true, false}) {
                gn_edge const edge = {GN_LINE_STROBE, ++edges_, rising, up_ns + (rising ? 0 : width_ns)};
                gn_ring_push(&shared_->strobes, &edge);
            }
        }
    }
    void acknowledge() {
        while (headers_read_ + GN_FRAME_HEADER_SIZE <= written_) {
            gn_frame_header const header = gn_frame_header_at(frames_.data() + headers_read_);
            acknowledged_ = header.sequence != 0 ? header.sequence : acknowledged_;
            headers_read_ += GN_FRAME_HEADER_SIZE + header.length;
        }
        std::uint8_t alive[GN_FRAME_HEADER_SIZE];
        gn_frame_begin(alive, GN_FRAME_ALIVE, 0, 0);
        gn_frame_seal(alive, acknowledged_);
        from_host_.insert(from_host_.end(), alive, alive + sizeof alive);
    }
    std::uint32_t look_at(const std::uint8_t *payload, std::uint64_t next_sample) const {
        gn_sample_block block{};
        std::memcpy(&block, payload, sizeof block);
        if (block.first_sample != next_sample || block.samples_lost != 0 || block.strobes_lost != 0) {
            throw std::runtime_error("samples or strobes were lost");
        }
        for (std::uint32_t i = 0; i < block.count; ++i) {
            std::uint64_t const n = next_sample + i;
            const std::uint8_t *sent = packets_.data() + n / samples_per_packet * packet_size +
                                       GN_DIGITISER_PACKET_SIZE + n % samples_per_packet * GN_SAMPLE_SIZE;
            if (std::memcmp(payload + sizeof block + i * GN_SAMPLE_SIZE, sent, GN_SAMPLE_SIZE) != 0) {
                throw std::runtime_error("a sample was changed");
            }
        }
        return block.count;
    }

    Bytes packets_;
    Bytes from_host_;
    Bytes frames_;
    std::unique_ptr<gn_shared> shared_ = std::make_unique<gn_shared>();
    gn_port port_{};
    gn_stream *stream_ = nullptr;
    std::int64_t now_ns_ = 0;
    std::size_t written_ = 0;
    std::size_t headers_read_ = 0;
    std::size_t next_packet_ = 0;
    std::uint32_t available_ = 0;
    std::uint32_t host_sequence_ = 0;
    std::uint32_t acknowledged_ = 0;
    std::uint32_t edges_ = 0;
    std::int64_t strobes_ = 0;
};

} // namespace

int main(int argc, char **argv) try {
    Sampler sampler;
    double const seconds = sampler.run();
    std::uint32_t const frames = sampler.look_over();
    for (int i = 1; i + 1 < argc; i += 2) {
        sampler.keep(argv[i + 1], std::strcmp(argv[i], "--packets") == 0);
    }
    std::printf("{\"samples\": %u, \"seconds\": %.6f, \"samples_per_s\": %.0f, \"frames\": %u, \"bytes\": %zu, "
                "\"samples_lost\": 0}\n",
                samples, seconds, samples / seconds, frames, sampler.written());
    return 0;
} catch (const std::exception &problem) {
    std::fprintf(stderr, "gonio-bench-sampler: %s\n", problem.what());
    return 1;
}
