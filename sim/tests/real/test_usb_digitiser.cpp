// test_usb_digitiser.cpp: vendor requests and packets as FunctionFS hands them over, played by pairs of sockets.
#include <array>
#include <cstring>

#include <gtest/gtest.h>
#include <linux/usb/functionfs.h>

#include "real_bench.hpp"
#include "usb_descriptors.hpp"
#include "usb_digitiser.hpp"

namespace gonio::sim {
namespace {

std::array<int, 2> pair_of_sockets() {
    std::array<int, 2> ends{};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, ends.data()), 0);
    return ends;
}

struct Gadget {
    explicit Gadget(const Digitiser_config &config = {})
        : digitiser(
              scheduler, config,
              [](std::uint64_t sample, std::int64_t) {
                  gn_sample value{};
                  value.high_counts = static_cast<std::int32_t>(sample);
                  return value;
              },
              [](bool) {}, [this] { usb.pump(); }) {}

    void event(std::uint8_t type) {
        usb_functionfs_event event{};
        event.type = type;
        host.say_block(event);
        usb.serve();
    }
    void request(std::uint8_t type, std::uint8_t number, std::uint16_t length) {
        usb_functionfs_event event{};
        event.type = FUNCTIONFS_SETUP;
        event.u.setup = {type, number, 0, 0, length};
        host.say_block(event);
    }
    void start(std::uint32_t period_us, std::uint32_t samples_per_strobe) {
        request(0x41, 1, 8);
        host.say_block(std::array<std::uint32_t, 2>{period_us, samples_per_strobe});
        usb.serve();
    }
    void run_ms(int duration_ms) {
        for (int k = 0; k < duration_ms; ++k) {
            std::int64_t const end_ns = scheduler.now_ns() + 1000000;
            while (scheduler.run_one(end_ns)) {
            }
            usb.serve();
        }
    }
    // Number of the next packet on the bulk endpoint; -1: none.
    int packet() {
        std::string const bytes = bulk.hear_now();
        gn_digitiser_packet header{};
        if (bytes.size() < sizeof header) {
            return -1;
        }
        std::memcpy(&header, bytes.data(), sizeof header);
        EXPECT_EQ(bytes.size(), sizeof header + header.count * sizeof(gn_sample)) << "one packet, one transfer";
        EXPECT_NE(bytes.size() % 64, 0U) << "a short USB packet ends it";
        flags = header.flags;
        return header.packet;
    }

    Scheduler scheduler{1000};
    std::array<int, 2> control = pair_of_sockets();
    std::array<int, 2> endpoint = pair_of_sockets();
    Peer host{control[1]};
    Peer bulk{endpoint[1]};
    Digitiser digitiser;
    Usb_digitiser usb{{control[0], endpoint[0]}, digitiser};
    int flags = 0;
};

} // namespace

TEST(Usb_digitiser, DescriptorsAreThoseOfTheProtocol) {
    std::array<std::uint8_t, sizeof digitiser_descriptors> bytes{};
    std::memcpy(bytes.data(), &digitiser_descriptors, sizeof bytes);
    // 12 bytes of head, two counts; then interface (9) and endpoint (7) for each speed.
    EXPECT_EQ(bytes.size(), 12U + 8U + 2U * 16U);
    std::array<std::uint8_t, 16> const full_speed = {9, 4, 0, 0, 1, 0xFF, 0x47, 0x44, 1, 7, 5, 0x81, 2, 64, 0, 0};
    EXPECT_EQ(std::memcmp(&bytes[20], full_speed.data(), 16), 0);
    EXPECT_EQ(bytes[36 + 13] + 256 * bytes[36 + 14], 512) << "high speed";
}

TEST(Usb_digitiser, StartBeginsAndStopEndsThePackets) {
    Gadget gadget;
    gadget.run_ms(100);
    EXPECT_EQ(gadget.packet(), -1);
    gadget.start(1000, 10);
    gadget.run_ms(220);
    for (int number = 0; number < 4; ++number) {
        EXPECT_EQ(gadget.packet(), number);
    }
    gadget.request(0x41, 2, 0);
    gadget.usb.serve();
    gadget.run_ms(200);
    EXPECT_EQ(gadget.packet(), -1);
    gadget.start(1000, 10);
    gadget.run_ms(60);
    EXPECT_EQ(gadget.packet(), 0) << "the counter begins anew";
}

TEST(Usb_digitiser, AnotherRequestStartsNothing) {
    Gadget gadget;
    gadget.request(0x41, 7, 0);
    gadget.request(0xC1, 1, 8);
    gadget.usb.serve();
    gadget.run_ms(100);
    EXPECT_EQ(gadget.digitiser.samples(), 0U);
}

TEST(Usb_digitiser, UnpluggedItForgetsThatItWasStarted) {
    Gadget gadget;
    gadget.start(1000, 10);
    gadget.run_ms(60);
    EXPECT_EQ(gadget.packet(), 0);
    gadget.event(FUNCTIONFS_DISABLE);
    gadget.run_ms(200);
    EXPECT_EQ(gadget.packet(), -1);
    gadget.event(FUNCTIONFS_ENABLE);
    gadget.run_ms(200);
    EXPECT_EQ(gadget.packet(), -1);
    gadget.start(1000, 10);
    gadget.run_ms(60);
    EXPECT_EQ(gadget.packet(), 0);
}

// 100 samples of 10 us to the packet: 1000 packets a second, which the host reads in heaps.
TEST(Usb_digitiser, AHundredThousandSamplesPerSecondArriveWhole) {
    Gadget gadget({.packet_samples = 100, .most_waiting_packets = 256});
    gadget.start(10, 100);
    int expected = 0;
    for (int heap = 0; heap < 50; ++heap) {
        gadget.run_ms(20);
        for (int number = gadget.packet(); number >= 0; number = gadget.packet()) {
            ASSERT_EQ(number, expected++);
            ASSERT_EQ(gadget.flags, 0);
        }
    }
    EXPECT_GE(expected, 950);
    EXPECT_EQ(gadget.digitiser.packets_lost(), 0U);
}

} // namespace gonio::sim
