// can_raw.cpp: SocketCAN's raw socket: stamps, a queue of its own.
#include "can_raw.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr std::int64_t second_ns = 1000000000;
constexpr std::int64_t retry_ns = 500000; // four frames of 1 Mbit/s
constexpr std::size_t queue_frames = 256; // as many as four drives send in half a second of heartbeats and PDOs
constexpr int receive_bytes = 1 << 20;    // a stall of a second loses nothing
constexpr std::int64_t believable_ns = 1000000000; // a stamp further from now shows a stepped wall clock

int open_socket(const std::string &interface) {
    int const descriptor = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (descriptor < 0) {
        throw Input_error("--can " + interface + ": this kernel has no CAN (" + std::strerror(errno) +
                          "); use --can socketcand:127.0.0.1:PORT");
    }
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
    if (address.can_ifindex == 0 ||
        bind(descriptor, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0) {
        std::string const why = std::strerror(errno);
        close(descriptor);
        throw Input_error("--can " + interface + ": no such interface (" + why + "); `ip link` lists them");
    }
    int const on = 1;
    setsockopt(descriptor, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    setsockopt(descriptor, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes);
    return descriptor;
}

std::int64_t clock_ns(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return now.tv_sec * second_ns + now.tv_nsec;
}

// The wall clock's stamp on the monotonic clock; without a believable one the present.
std::int64_t stamp_of(msghdr &message) {
    std::int64_t const now_ns = clock_ns(CLOCK_MONOTONIC);
    for (cmsghdr *part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
        if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SCM_TIMESTAMPNS) {
            timespec wall{};
            std::memcpy(&wall, CMSG_DATA(part), sizeof wall);
            std::int64_t const age_ns = clock_ns(CLOCK_REALTIME) - (wall.tv_sec * second_ns + wall.tv_nsec);
            return age_ns >= 0 && age_ns < believable_ns ? now_ns - age_ns : now_ns;
        }
    }
    return now_ns;
}

} // namespace

Can_raw::Can_raw(Scheduler &scheduler, const std::string &interface) : Can_raw(scheduler, open_socket(interface)) {}

Can_raw::Can_raw(Scheduler &scheduler, int descriptor) : scheduler_(scheduler), socket_(descriptor) {}

Can_raw::~Can_raw() {
    close(socket_);
}

void Can_raw::wait_for(std::vector<pollfd> &descriptors) const {
    descriptors.push_back({socket_, POLLIN, 0});
}

void Can_raw::serve() {
    for (;;) {
        can_frame raw{};
        iovec part{&raw, sizeof raw};
        std::array<char, 64> extra{};
        msghdr message{};
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = extra.data();
        message.msg_controllen = extra.size();
        // Nothing more, or the interface is down: it says so once and goes on when it is up again.
        if (recvmsg(socket_, &message, MSG_DONTWAIT) != static_cast<ssize_t>(sizeof raw)) {
            return;
        }
        if ((raw.can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_ERR_FLAG)) != 0 || raw.can_dlc > sizeof raw.data) {
            continue;
        }
        gn_can_frame frame{};
        frame.id = raw.can_id & CAN_SFF_MASK;
        frame.length = raw.can_dlc;
        std::memcpy(frame.data, raw.data, sizeof frame.data);
        frame.stamp_ns = stamp_of(message);
        hear(frame);
    }
}

Can_raw::Sent Can_raw::write_frame(const gn_can_frame &frame) const {
    can_frame raw{};
    raw.can_id = frame.id;
    raw.can_dlc = frame.length;
    std::memcpy(raw.data, frame.data, sizeof raw.data);
    if (::send(socket_, &raw, sizeof raw, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(sizeof raw)) {
        return Sent::yes;
    }
    return errno == ENOBUFS || errno == EAGAIN || errno == EINTR ? Sent::later : Sent::never;
}

void Can_raw::send(const gn_can_frame &frame) {
    queue_.push_back(frame);
    if (queue_.size() > queue_frames) {
        queue_.pop_front();
        ++dropped_;
    }
    if (!retry_due_) {
        empty_queue();
    }
}

// ENOBUFS has no event that says when it is over: ask again.
void Can_raw::empty_queue() {
    while (!queue_.empty()) {
        Sent const sent = write_frame(queue_.front());
        if (sent == Sent::later) {
            retry_due_ = true;
            scheduler_.after(retry_ns, [this] {
                retry_due_ = false;
                empty_queue();
            });
            return;
        }
        dropped_ += sent == Sent::never ? 1U : 0U;
        queue_.pop_front();
    }
}

} // namespace gonio::sim
