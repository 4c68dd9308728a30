// tcp_host.hpp: the stream thread behind the link of port/linux, and hosts that reach it through real sockets.
#ifndef GONIO_TEST_TCP_HOST_HPP
#define GONIO_TEST_TCP_HOST_HPP

#include <arpa/inet.h>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <netinet/in.h>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "gonio.pb.h"
#include "pb_decode.h"
#include "pb_encode.h"

extern "C" {
#include "frame.h"
#include "link_linux.h"
#include "link_tcp.h"
#include "stream.h"
}

namespace gonio::test {

using Bytes = std::vector<std::uint8_t>;

// Turns until a condition holds; a turn waits for at most 10 ms, so that a limit of turns is a generous time.
constexpr int turns_at_most = 500;

class Served {
public:
    gn_link_linux *link = nullptr;
    gn_link_port port{};
    gn_stream *stream = nullptr;
    std::unique_ptr<gn_shared> shared = std::make_unique<gn_shared>();
    std::vector<std::string> log;

    Served() {
        gn_link_settings settings{};
        settings.tcp = true;
        char error[160];
        link = gn_link_linux_open(&settings, error, sizeof error);
        if (link == nullptr) {
            throw std::runtime_error(error);
        }
        gn_link_linux_port(link, &port);
        gn_shared_init(shared.get());
        ports_.link = port;
        ports_.digitiser = {this, [](void *, std::uint32_t, std::uint32_t) { return -1; }, [](void *) {},
                            [](void *, std::uint8_t *, std::size_t) { return -1; }};
        ports_.log = {this, [](void *self, gn_log_level, const char *text) {
                          static_cast<Served *>(self)->log.emplace_back(text);
                      }};
        stream = gn_stream_init(&ports_, shared.get(), "bench", 0x1000);
    }
    ~Served() { gn_link_linux_close(link); }
    Served(const Served &) = delete;
    Served &operator=(const Served &) = delete;

    void turn() {
        wait(10);
        gn_link_linux_process(link);
        now_ns_ += 1000000;
        gn_stream_process(stream, now_ns_);
    }
    template <typename Condition> bool turn_until(Condition holds) {
        for (int i = 0; i < turns_at_most; ++i) {
            if (holds()) {
                return true;
            }
            turn();
        }
        return holds();
    }
    // Descriptors that are ready within the time.
    int wait(int milliseconds) const {
        pollfd polls[GN_LINK_POLLS];
        return poll(polls, gn_link_linux_polls(link, polls), milliseconds);
    }

private:
    gn_port ports_{};
    std::int64_t now_ns_ = 1000000000;
};

class Host {
public:
    explicit Host(std::uint16_t tcp_port, int receive_buffer = 0) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
        if (receive_buffer > 0) {
            setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
        }
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(tcp_port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        if (connect(fd_, reinterpret_cast<sockaddr *>(&address), sizeof address) != 0) {
            throw std::runtime_error("cannot connect");
        }
    }
    ~Host() { hang_up(); }
    Host(const Host &) = delete;
    Host &operator=(const Host &) = delete;

    void hang_up() {
        if (fd_ >= 0) {
            close(std::exchange(fd_, -1));
        }
    }
    // As when the host's machine goes down: not even an orderly end.
    void vanish() {
        linger const at_once = {1, 0};
        setsockopt(fd_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
        hang_up();
    }
    void raw(const Bytes &bytes) const {
        if (send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(bytes.size())) {
            throw std::runtime_error("cannot send");
        }
    }
    template <typename Message>
    void frame(std::uint32_t kind, std::uint32_t sequence, const pb_msgdesc_t *fields, const Message &message) const {
        Bytes bytes(GN_FRAME_HEADER_SIZE + 2048);
        pb_ostream_t out = pb_ostream_from_buffer(bytes.data() + GN_FRAME_HEADER_SIZE, 2048);
        if (!pb_encode(&out, fields, &message)) {
            throw std::runtime_error(PB_GET_ERROR(&out));
        }
        bytes.resize(GN_FRAME_HEADER_SIZE + out.bytes_written);
        gn_frame_begin(bytes.data(), kind, sequence, static_cast<std::uint32_t>(out.bytes_written));
        gn_frame_seal(bytes.data(), 0);
        raw(bytes);
    }
    void hello(gonio_Role role) const {
        gonio_Hello message = gonio_Hello_init_zero;
        message.schema_hash = GN_SCHEMA_HASH;
        message.role = role;
        frame(GN_FRAME_HELLO, 0, gonio_Hello_fields, message);
    }
    void request(std::uint32_t id, pb_size_t body) {
        gonio_Request message = gonio_Request_init_zero;
        message.id = id;
        message.which_body = body;
        frame(GN_FRAME_REQUEST, ++sequence_, gonio_Request_fields, message);
    }
    // One more frame has come whole. Its payload is at payload().
    bool has_frame() {
        for (;;) {
            std::size_t taken = 0;
            auto const progress = gn_frame_decode(decoder_.get(), come_.data() + read_, come_.size() - read_, &taken);
            read_ += taken;
            if (progress == GN_FRAME_REFUSED) {
                throw std::runtime_error(gn_frame_error_text(decoder_->error));
            }
            if (progress == GN_FRAME_COMPLETE) {
                return true;
            }
            if (!more_bytes()) {
                return false;
            }
        }
    }
    bool has_frame(std::uint32_t kind) { return has_frame() && header().kind == kind; }
    // The other side has closed, and all that it sent is read.
    bool ended() {
        while (has_frame()) {
        }
        return ended_;
    }
    bool was_reset() const { return reset_; }
    gn_frame_header header() const { return gn_frame_header_at(decoder_->bytes); }
    template <typename Message> Message as(const pb_msgdesc_t *fields) const {
        Message message{};
        pb_istream_t in = pb_istream_from_buffer(decoder_->bytes + GN_FRAME_HEADER_SIZE, header().length);
        if (!pb_decode(&in, fields, &message)) {
            throw std::runtime_error(PB_GET_ERROR(&in));
        }
        return message;
    }

private:
    bool more_bytes() {
        come_.resize(4096);
        ssize_t const length = recv(fd_, come_.data(), come_.size(), MSG_DONTWAIT);
        reset_ = reset_ || (length < 0 && errno == ECONNRESET);
        ended_ = ended_ || length == 0 || (length < 0 && errno != EAGAIN && errno != EWOULDBLOCK);
        come_.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
        read_ = 0;
        return length > 0;
    }

    int fd_;
    Bytes come_;
    std::size_t read_ = 0; // of what has come
    bool ended_ = false;
    bool reset_ = false;
    std::uint32_t sequence_ = 0;
    std::unique_ptr<gn_frame_decoder> decoder_ = std::make_unique<gn_frame_decoder>();
};

} // namespace gonio::test

#endif
