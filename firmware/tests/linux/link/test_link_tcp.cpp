// test_link_tcp.cpp: the firmware's session over real sockets: HELLO, requests, a third client, a client that does not
// read, and the end of a connection from either side.
#include <cstring>
#include <net/if.h>
#include <sys/ioctl.h>

#include <gtest/gtest.h>

#include "tcp_host.hpp"

namespace {

using gonio::test::Bytes;
using gonio::test::Host;
using gonio::test::Served;

class Link_tcp : public testing::Test {
protected:
    Served served;
    std::uint16_t port = gn_link_linux_tcp_port(served.link);

    void greet(Host &host, gonio_Role role) {
        host.hello(role);
        ASSERT_TRUE(served.turn_until([&] { return host.has_frame(GN_FRAME_HELLO); }));
        EXPECT_STREQ(host.as<gonio_Hello>(gonio_Hello_fields).refusal, "");
    }
    // The motion side answers the one request that waits.
    void answer_info() {
        gn_command command{};
        ASSERT_TRUE(served.turn_until([&] { return gn_ring_pop(&served.shared->commands, &command); }));
        gn_notice notice{};
        notice.is_reply = true;
        notice.as.reply.id = command.request.id;
        notice.as.reply.which_body = gonio_Reply_info_tag;
        ASSERT_TRUE(gn_ring_push(&served.shared->notices, &notice));
    }
};

TEST_F(Link_tcp, a_driver_gets_hello_and_info) {
    ASSERT_NE(port, 0);
    Host host(port);
    greet(host, gonio_Role_ROLE_DRIVER);
    EXPECT_EQ(host.as<gonio_Hello>(gonio_Hello_fields).session_id, 0x1000u);
    host.request(7, gonio_Request_get_info_tag);
    answer_info();
    ASSERT_TRUE(served.turn_until([&] { return host.has_frame(GN_FRAME_REPLY); }));
    auto const reply = host.as<gonio_Reply>(gonio_Reply_fields);
    EXPECT_EQ(reply.id, 7u);
    EXPECT_STREQ(reply.body.info.device, "bench");
    EXPECT_TRUE(reply.body.info.driver_connected);
}

TEST_F(Link_tcp, a_visitor_stops_the_motion) {
    Host driver(port);
    greet(driver, gonio_Role_ROLE_DRIVER);
    Host visitor(port);
    greet(visitor, gonio_Role_ROLE_VISITOR);
    visitor.request(1, gonio_Request_stop_tag);
    ASSERT_TRUE(served.turn_until([&] { return visitor.has_frame(GN_FRAME_REPLY); }));
    EXPECT_EQ(visitor.as<gonio_Reply>(gonio_Reply_fields).code, gonio_ReplyCode_REPLY_OK);
    EXPECT_EQ(served.shared->stop_requested, 1u);
    EXPECT_TRUE(served.turn_until([&] { return driver.has_frame(GN_FRAME_EVENT); })) << "the driver is told";
}

TEST_F(Link_tcp, a_third_client_is_turned_away_and_the_others_stay) {
    Host driver(port);
    greet(driver, gonio_Role_ROLE_DRIVER);
    Host visitor(port);
    greet(visitor, gonio_Role_ROLE_VISITOR);
    Host third(port);
    EXPECT_TRUE(served.turn_until([&] { return third.ended(); }));
    visitor.request(1, gonio_Request_stop_tag);
    EXPECT_TRUE(served.turn_until([&] { return visitor.has_frame(GN_FRAME_REPLY); }));
}

TEST_F(Link_tcp, a_place_is_free_again_when_its_client_has_gone) {
    for (int i = 0; i < 5; ++i) {
        Host driver(port);
        greet(driver, gonio_Role_ROLE_DRIVER);
        Host visitor(port);
        greet(visitor, gonio_Role_ROLE_VISITOR);
        driver.hang_up();
        visitor.hang_up();
        ASSERT_TRUE(served.turn_until([&] {
            std::uint8_t byte = 0;
            return served.port.read(served.port.context, 1, &byte, 1) < 0 &&
                   served.port.read(served.port.context, 2, &byte, 1) < 0;
        }));
        served.turn(); // the core learns it too
    }
}

TEST_F(Link_tcp, a_refusal_arrives_before_the_end) {
    Host driver(port);
    greet(driver, gonio_Role_ROLE_DRIVER);
    Host second(port);
    second.hello(gonio_Role_ROLE_DRIVER);
    second.raw(Bytes(20000, 0)); // bytes that nobody will read must not turn the end into a reset
    ASSERT_TRUE(served.turn_until([&] { return second.has_frame(GN_FRAME_HELLO); }));
    EXPECT_NE(std::string(second.as<gonio_Hello>(gonio_Hello_fields).refusal), "");
    EXPECT_TRUE(served.turn_until([&] { return second.ended(); }));
    EXPECT_FALSE(second.was_reset());
}

TEST_F(Link_tcp, bytes_that_are_no_frames_end_the_connection) {
    Host host(port);
    greet(host, gonio_Role_ROLE_VISITOR);
    host.raw(Bytes(64, 0x55));
    EXPECT_TRUE(served.turn_until([&] { return host.ended(); }));
    ASSERT_FALSE(served.log.empty());
}

TEST_F(Link_tcp, a_visitor_that_does_not_read_is_cut_off_and_the_driver_served) {
    Host driver(port);
    greet(driver, gonio_Role_ROLE_DRIVER);
    Host visitor(port, 4096);
    greet(visitor, gonio_Role_ROLE_VISITOR);
    auto const dismissed = [&] {
        for (auto const &line : served.log) {
            if (line.find("does not read") != std::string::npos) {
                return true;
            }
        }
        return false;
    };
    // Each of its requests is refused in a sentence; nothing of this goes to the driver.
    for (std::uint32_t id = 1; id <= 200000 && !dismissed(); ++id) {
        visitor.request(id, gonio_Request_acquire_tag);
        if (id % 100 == 0) {
            served.turn();
        }
    }
    EXPECT_TRUE(dismissed());
    driver.request(1, gonio_Request_stop_tag);
    EXPECT_TRUE(served.turn_until([&] { return driver.has_frame(GN_FRAME_REPLY); }));
}

TEST_F(Link_tcp, whoever_the_core_does_not_read_wakes_nobody) {
    Host host(port);
    std::uint8_t byte = 0;
    ASSERT_TRUE(served.turn_until([&] { return served.port.read(served.port.context, 1, &byte, 1) == 0; }));
    host.raw({1, 2, 3});
    EXPECT_EQ(served.wait(10000), 1) << "a client that is read does";
    gn_link_linux_process(served.link);
    EXPECT_EQ(served.wait(0), 0);
    host.vanish();
    EXPECT_EQ(served.wait(0), 0) << "not even by its end";
    EXPECT_TRUE(served.turn_until([&] { return served.port.read(served.port.context, 1, &byte, 1) < 0; }));
}

TEST_F(Link_tcp, what_the_kernel_does_not_take_is_offered_again) {
    Host host(port, 4096);
    std::uint8_t byte = 0;
    ASSERT_TRUE(served.turn_until([&] { return served.port.read(served.port.context, 1, &byte, 1) == 0; }));
    Bytes const block(1 << 20, 7);
    int taken = 0;
    do {
        taken = served.port.write(served.port.context, 1, block.data(), block.size());
        ASSERT_GE(taken, 0);
    } while (taken > 0);
    pollfd polls[GN_LINK_POLLS];
    std::uint32_t const count = gn_link_linux_polls(served.link, polls);
    EXPECT_NE(polls[count - 1].events & POLLOUT, 0);
    EXPECT_EQ(served.port.read(served.port.context, 1, &byte, 1), 0) << "slow is not gone";
}

TEST_F(Link_tcp, the_usb_client_is_absent_without_usb) {
    std::uint8_t byte = 0;
    EXPECT_EQ(served.port.read(served.port.context, 0, &byte, 1), -1);
    EXPECT_EQ(served.port.write(served.port.context, 0, &byte, 1), -1);
    served.port.close(served.port.context, 0);
}

TEST_F(Link_tcp, only_loopback_listens) {
    int const probe = socket(AF_INET, SOCK_DGRAM, 0);
    ifconf list{};
    char buffer[4096];
    list.ifc_len = sizeof buffer;
    list.ifc_buf = buffer;
    ASSERT_EQ(ioctl(probe, SIOCGIFCONF, &list), 0);
    close(probe);
    int others = 0;
    for (int at = 0; at < list.ifc_len; at += static_cast<int>(sizeof(ifreq))) {
        sockaddr_in address{};
        std::memcpy(&address, &reinterpret_cast<ifreq *>(buffer + at)->ifr_addr, sizeof address);
        if (ntohl(address.sin_addr.s_addr) >> 24u == 127u) {
            continue;
        }
        ++others;
        address.sin_port = htons(port);
        int const fd = socket(AF_INET, SOCK_STREAM, 0);
        EXPECT_NE(connect(fd, reinterpret_cast<sockaddr *>(&address), sizeof address), 0);
        EXPECT_EQ(errno, ECONNREFUSED);
        close(fd);
    }
    if (others == 0) {
        GTEST_SKIP() << "this machine has no network but loopback";
    }
}

TEST(Link_settings, neither_usb_nor_tcp_is_an_error) {
    gn_link_settings const settings{};
    char error[160] = "";
    EXPECT_EQ(gn_link_linux_open(&settings, error, sizeof error), nullptr);
    EXPECT_STREQ(error, "link: neither USB nor TCP: set link.functionfs or link.tcp_port");
}

TEST(Link_settings, a_port_in_use_is_named) {
    Served const other;
    gn_link_tcp second{};
    char error[160] = "";
    std::uint16_t const port = gn_link_linux_tcp_port(other.link);
    EXPECT_FALSE(gn_link_tcp_open(&second, port, error, sizeof error));
    EXPECT_EQ(std::string(error), "link: cannot listen on 127.0.0.1:" + std::to_string(port) +
                                      ": Address already in use; is another goniod running? choose another "
                                      "link.tcp_port");
}

TEST(Link_settings, a_folder_without_functionfs_is_named) {
    gn_link_settings settings{"/nonexistent/ffs", 0, false};
    char error[200] = "";
    EXPECT_EQ(gn_link_linux_open(&settings, error, sizeof error), nullptr);
    EXPECT_STREQ(error, "link: cannot open /nonexistent/ffs/ep0: No such file or directory; is FunctionFS mounted "
                        "there, for this user, and no other goniod at it?");
}

} // namespace
