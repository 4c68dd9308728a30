// test_watchdog_device.cpp: the bytes of the kernel's watchdog interface (Documentation/watchdog/watchdog-api), and its
// refusals. This machine has no watchdog that a test may arm.
#include <string>

#include <unistd.h>

#include <gtest/gtest.h>

extern "C" {
#include "watchdog_device.h"
}

namespace {

TEST(Watchdog_device, keeps_alive_by_any_byte_but_the_magic_one_and_closes_with_it) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    gn_watchdog_keep_alive(ends[1]);
    gn_watchdog_keep_alive(ends[1]);
    gn_watchdog_close(ends[1]);
    char bytes[16];
    ssize_t const length = read(ends[0], bytes, sizeof bytes);
    ASSERT_EQ(length, 3);
    EXPECT_NE(bytes[0], 'V');
    EXPECT_NE(bytes[1], 'V');
    EXPECT_EQ(bytes[2], 'V') << "else the board is reset after a controlled end";
    EXPECT_EQ(read(ends[0], bytes, sizeof bytes), 0) << "closed";
    close(ends[0]);
}

TEST(Watchdog_device, no_path_is_no_error) {
    char error[200] = "";
    EXPECT_EQ(gn_watchdog_open("", error, sizeof error), -1);
    EXPECT_STREQ(error, "");
    gn_watchdog_keep_alive(-1);
    gn_watchdog_close(-1);
}

TEST(Watchdog_device, what_is_no_watchdog_is_refused_with_its_name) {
    char error[200] = "";
    EXPECT_EQ(gn_watchdog_open("/nonexistent/watchdog", error, sizeof error), -1);
    EXPECT_EQ(std::string(error).rfind("watchdog.device /nonexistent/watchdog: No such file", 0), 0u) << error;
    EXPECT_EQ(gn_watchdog_open("/dev/null", error, sizeof error), -1);
    EXPECT_EQ(std::string(error).rfind("watchdog.device /dev/null: Inappropriate ioctl", 0), 0u) << error;
}

} // namespace
