// test_notify.cpp: what systemd hears, on a socket like its own (sd_notify(3)).
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <gtest/gtest.h>

extern "C" {
#include "notify.h"
}

namespace {

class Notify : public testing::Test {
protected:
    int socket_ = -1;

    void bind_to(const std::string &name) {
        socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::memcpy(address.sun_path, name.data(), name.size());
        auto const size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
        ASSERT_EQ(bind(socket_, reinterpret_cast<const sockaddr *>(&address), size), 0);
    }
    std::string heard() const {
        char bytes[256];
        ssize_t const length = recv(socket_, bytes, sizeof bytes, 0);
        return {bytes, length < 0 ? 0u : static_cast<std::size_t>(length)};
    }
    void TearDown() override {
        for (const char *name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) {
            unsetenv(name);
        }
        if (socket_ >= 0) {
            close(socket_);
        }
    }
};

TEST_F(Notify, a_path_and_an_abstract_name) {
    std::string const path = testing::TempDir() + "gn_notify_" + std::to_string(getpid());
    bind_to(path);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
    EXPECT_TRUE(gn_notify("READY=1\nSTATUS=two lines"));
    EXPECT_EQ(heard(), "READY=1\nSTATUS=two lines");
    unlink(path.c_str());
    close(socket_);

    std::string const name = "gn_notify_" + std::to_string(getpid());
    bind_to(std::string(1, '\0') + name);
    setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
    EXPECT_TRUE(gn_notify("WATCHDOG=1"));
    EXPECT_EQ(heard(), "WATCHDOG=1");
}

TEST_F(Notify, without_systemd_nothing_happens) {
    EXPECT_FALSE(gn_notify("READY=1"));
    setenv("NOTIFY_SOCKET", "/nonexistent/socket", 1);
    EXPECT_FALSE(gn_notify("READY=1"));
    setenv("NOTIFY_SOCKET", "relative", 1);
    EXPECT_FALSE(gn_notify("READY=1"));
    setenv("NOTIFY_SOCKET", ("/" + std::string(200, 'x')).c_str(), 1);
    EXPECT_FALSE(gn_notify("READY=1"));
}

TEST_F(Notify, a_receiver_that_does_not_read_makes_nobody_wait) {
    std::string const name = "gn_notify_full_" + std::to_string(getpid());
    bind_to(std::string(1, '\0') + name);
    setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
    int sent = 0;
    while (sent < 100000 && gn_notify("WATCHDOG=1")) {
        ++sent;
    }
    EXPECT_GT(sent, 0);
    EXPECT_LT(sent, 100000) << "the queue never became full";
}

TEST_F(Notify, the_watchdog_interval_is_taken_if_it_is_meant_for_us) {
    EXPECT_EQ(gn_notify_watchdog_ns(), 0);
    setenv("WATCHDOG_USEC", "2000000", 1);
    EXPECT_EQ(gn_notify_watchdog_ns(), 2000000000);
    setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
    EXPECT_EQ(gn_notify_watchdog_ns(), 2000000000);
    setenv("WATCHDOG_PID", std::to_string(getpid() + 1).c_str(), 1);
    EXPECT_EQ(gn_notify_watchdog_ns(), 0);
    unsetenv("WATCHDOG_PID");
    for (const char *nonsense : {"", "0", "-5", "2s", "99999999999999999999"}) {
        setenv("WATCHDOG_USEC", nonsense, 1);
        EXPECT_EQ(gn_notify_watchdog_ns(), 0) << nonsense;
    }
}

} // namespace
