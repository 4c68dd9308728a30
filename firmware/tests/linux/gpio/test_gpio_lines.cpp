// test_gpio_lines.cpp: lines that are not wired, and settings that cannot be met. Real lines: hil-tests, on gpio-sim.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>

extern "C" {
#include "gpio_lines.h"
}

namespace {

TEST(Gpio_lines, what_is_not_wired_reads_safe_and_takes_orders) {
    gn_gpio_settings const settings{};
    char error[160] = "";
    gn_gpio_lines *lines = gn_gpio_open(&settings, error, sizeof error);
    ASSERT_NE(lines, nullptr) << error;
    gn_edge_port edge{};
    gn_out_port out{};
    gn_gpio_ports(lines, &edge, &out);
    EXPECT_FALSE(edge.level(edge.context, GN_LINE_STROBE));
    for (std::uint32_t line = GN_LINE_DOOR; line < GN_LINE_COUNT; line++) {
        EXPECT_TRUE(edge.level(edge.context, line)) << line;
    }
    gn_edge e{};
    EXPECT_EQ(edge.receive(edge.context, &e), 0);
    out.set(out.context, GN_OUT_SHUTTER, true);
    out.pulse_watchdog(out.context);
    int fds[GN_GPIO_FDS];
    EXPECT_EQ(gn_gpio_fds(lines, fds), 0u);
    gn_gpio_close(lines);
}

TEST(Gpio_lines, an_absent_chip_is_named_with_its_line) {
    for (const char *chip : {"gonio-none", "/dev/gonio-none", "/dev/null"}) {
        gn_gpio_settings settings{};
        char error[200] = "";
        settings.inputs[GN_LINE_DOOR].used = true;
        (void)std::snprintf(settings.inputs[GN_LINE_DOOR].chip, sizeof settings.inputs[0].chip, "%s", chip);
        EXPECT_EQ(gn_gpio_open(&settings, error, sizeof error), nullptr);
        EXPECT_NE(std::strstr(error, "input.door: no GPIO chip has the path, name or label"), nullptr) << error;
        EXPECT_NE(std::strstr(error, chip), nullptr) << error;
        settings.inputs[GN_LINE_DOOR].used = false;
        settings.outputs[GN_GPIO_WATCHDOG].used = true;
        (void)std::snprintf(settings.outputs[GN_GPIO_WATCHDOG].chip, sizeof settings.outputs[0].chip, "%s", chip);
        EXPECT_EQ(gn_gpio_open(&settings, error, sizeof error), nullptr);
        EXPECT_NE(std::strstr(error, "output.watchdog"), nullptr) << error;
    }
}

} // namespace
