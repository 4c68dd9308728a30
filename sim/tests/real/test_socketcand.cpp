// test_socketcand.cpp: the words of the socketcand protocol, as its raw mode and python-can's client have them.
#include <vector>

#include <gtest/gtest.h>

#include "real_bench.hpp"
#include "socketcand.hpp"

namespace gonio::sim {
namespace {

struct Served {
    Served() {
        wire.on_frame([this](const gn_can_frame &frame) { heard.push_back(frame); });
    }
    // Time passes while the server is served, so that whatever the client said has come.
    std::string answer(const Peer &peer) {
        for (int k = 0; k < 1000; ++k) {
            wire.serve();
            if (std::string text = peer.hear_now(); !text.empty()) {
                return text;
            }
            usleep(1000);
        }
        return "";
    }
    void serve_until(std::size_t frames) {
        for (int k = 0; k < 1000 && heard.size() < frames; ++k) {
            wire.serve();
            usleep(1000);
        }
    }
    void open(const Peer &peer) {
        EXPECT_EQ(answer(peer), "< hi >");
        peer.say("< open can0 >");
        EXPECT_EQ(answer(peer), "< ok >");
        peer.say("< rawmode >");
        EXPECT_EQ(answer(peer), "< ok >");
    }
    Scheduler scheduler{monotonic_ns()};
    std::vector<gn_can_frame> heard;
    Socketcand wire{scheduler, "127.0.0.1", 0};
};

gn_can_frame frame_of(std::uint32_t id, const std::vector<std::uint8_t> &data) {
    gn_can_frame frame{};
    frame.id = id;
    frame.length = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), frame.data);
    frame.stamp_ns = 12345678000;
    return frame;
}

} // namespace

TEST(Socketcand, AClientIsGreetedAndItsFramesReachTheBus) {
    Served served;
    Peer const peer = Peer::tcp(served.wire.port());
    served.open(peer);
    peer.say("< send 601 8 40 0 10 0 0 0 0 a >< send 080 0  >");
    served.serve_until(2);
    ASSERT_EQ(served.heard.size(), 2U);
    EXPECT_EQ(served.heard[0].id, 0x601U);
    EXPECT_EQ(served.heard[0].length, 8);
    EXPECT_EQ(served.heard[0].data[2], 0x10);
    EXPECT_EQ(served.heard[0].data[7], 0x0A);
    EXPECT_GT(served.heard[0].stamp_ns, 0);
    EXPECT_EQ(served.heard[1].id, 0x080U);
    EXPECT_EQ(served.heard[1].length, 0);
}

TEST(Socketcand, FramesOfTheDrivesAreWrittenInRawModesWords) {
    Served served;
    Peer const peer = Peer::tcp(served.wire.port());
    served.open(peer);
    peer.say("< send 000 2 1 0 >"); // it has read the answer to "rawmode"
    served.serve_until(1);
    served.wire.send(frame_of(0x581, {0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00}));
    served.wire.send(frame_of(0x081, {}));
    std::string text;
    for (int k = 0; k < 100 && text.find("081") == std::string::npos; ++k) {
        text += peer.hear();
    }
    EXPECT_EQ(text, "< frame 581 12.345678 4300100092010200 >< frame 081 12.345678  >");
}

TEST(Socketcand, FramesAreHeldBackUntilTheAnswerToRawmodeHasBeenRead) {
    Served served;
    Peer const peer = Peer::tcp(served.wire.port());
    served.open(peer);
    served.wire.send(frame_of(0x701, {0}));
    EXPECT_EQ(peer.hear_now(), "") << "python-can would take it for a wrong answer";
    while (served.scheduler.run_one(monotonic_ns() + 100000000)) {
    }
    served.wire.send(frame_of(0x702, {0}));
    EXPECT_EQ(peer.hear(), "< frame 702 12.345678 00 >");
}

TEST(Socketcand, ClientsHearEachOtherButNotThemselves) {
    Served served;
    Peer const one = Peer::tcp(served.wire.port());
    served.open(one);
    Peer const two = Peer::tcp(served.wire.port());
    served.open(two);
    one.say("< send 001 1 7 >");
    two.say("< send 002 1 8 >");
    served.serve_until(2);
    one.say("< send 003 1 9 >");
    EXPECT_NE(served.answer(two).find("< frame 003"), std::string::npos);
    EXPECT_EQ(one.hear_now().find("< frame 001"), std::string::npos);
}

TEST(Socketcand, WhatIsNotAStandardDataFrameIsNotSent) {
    Served served;
    Peer const peer = Peer::tcp(served.wire.port());
    served.open(peer);
    peer.say("< send 00000601 1 0 >< send 800 1 0 >< send 701 1  >< send 701 9 0 0 0 0 0 0 0 0 0 >< send 601 1 100 >"
             "< send 602 1 5 >");
    served.serve_until(1);
    ASSERT_EQ(served.heard.size(), 1U);
    EXPECT_EQ(served.heard[0].id, 0x602U);
    peer.say("< wibble >");
    EXPECT_EQ(served.answer(peer), "< error unknown command >");
}

TEST(Socketcand, AClientThatHangsUpOrTalksNonsenseIsForgotten) {
    Served served;
    Peer gone = Peer::tcp(served.wire.port());
    served.open(gone);
    gone.hang_up();
    Peer const babbler = Peer::tcp(served.wire.port());
    EXPECT_EQ(served.answer(babbler), "< hi >");
    babbler.say(std::string(5000, 'x'));
    std::vector<pollfd> waited;
    for (int k = 0; k < 1000; ++k) {
        served.wire.serve();
        waited.clear();
        served.wire.wait_for(waited);
        if (waited.size() == 1) {
            break;
        }
        usleep(1000);
    }
    EXPECT_EQ(waited.size(), 1U) << "only the listener is left";
}

} // namespace gonio::sim
