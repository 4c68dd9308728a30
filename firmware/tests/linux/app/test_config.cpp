// test_config.cpp: the settings file: every key, its refusals with file and line, and the file that the package
// installs.
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

extern "C" {
#include "config.h"
}

namespace {

struct Parsed {
    gn_config config{};
    bool good = false;
    std::string error;
};

Parsed parse(const std::string &text) {
    Parsed parsed;
    char error[256] = "";
    gn_config_defaults(&parsed.config);
    parsed.good = gn_config_parse(&parsed.config, "a.conf", text.data(), text.size(), error, sizeof error);
    parsed.error = error;
    return parsed;
}

TEST(Config, every_key_reaches_its_place) {
    Parsed const parsed = parse("device.name = board-2\n"
                                "can.interface = can1 # the second\n"
                                "can.sync_stamp_sigma_us = 7.5\r\n"
                                "input.strobe = gpiochip0:4\n"
                                "input.door = pinctrl-bcm2711:5 active-low\n"
                                "input.emergency_stop = /dev/gpiochip3:17\n"
                                "input.sto=none\n"
                                "\tinput.limit = fe200000.gpio:1023\tactive-low  \n"
                                "output.shutter = gpiochip12:0\n"
                                "output.lamp = none\n"
                                "output.watchdog = gpiochip0:9\n"
                                "gpio.event_buffer = 64\n"
                                "digitiser.usb_id = 16C0:05df\n"
                                "digitiser.serial = D-0007\n"
                                "link.functionfs = /run/gonio/ffs\n"
                                "link.tcp_port = any\n"
                                "realtime.motion_priority = 90\n"
                                "realtime.stream_priority = 0\n"
                                "realtime.motion_cpu = 3\n"
                                "watchdog.device = /dev/watchdog");
    ASSERT_TRUE(parsed.good) << parsed.error;
    gn_config const &config = parsed.config;
    EXPECT_STREQ(config.device_name, "board-2");
    EXPECT_STREQ(config.can.interface, "can1");
    EXPECT_FLOAT_EQ(config.can.sync_stamp_sigma_us, 7.5F);
    gn_gpio_line const &strobe = config.gpio.inputs[GN_LINE_STROBE];
    EXPECT_TRUE(strobe.used);
    EXPECT_FALSE(strobe.active_low);
    EXPECT_STREQ(strobe.chip, "/dev/gpiochip0");
    EXPECT_EQ(strobe.offset, 4u);
    gn_gpio_line const &door = config.gpio.inputs[GN_LINE_DOOR];
    EXPECT_TRUE(door.active_low);
    EXPECT_STREQ(door.chip, "pinctrl-bcm2711");
    EXPECT_EQ(door.offset, 5u);
    EXPECT_STREQ(config.gpio.inputs[GN_LINE_EMERGENCY_STOP].chip, "/dev/gpiochip3");
    EXPECT_FALSE(config.gpio.inputs[GN_LINE_STO].used);
    EXPECT_TRUE(config.gpio.inputs[GN_LINE_LIMIT].active_low);
    EXPECT_EQ(config.gpio.inputs[GN_LINE_LIMIT].offset, 1023u);
    EXPECT_STREQ(config.gpio.outputs[GN_GPIO_SHUTTER].chip, "/dev/gpiochip12");
    EXPECT_FALSE(config.gpio.outputs[GN_GPIO_LAMP].used);
    EXPECT_EQ(config.gpio.outputs[GN_GPIO_WATCHDOG].offset, 9u);
    EXPECT_EQ(config.gpio.event_buffer, 64u);
    EXPECT_EQ(config.digitiser.vendor_id, 0x16C0u);
    EXPECT_EQ(config.digitiser.product_id, 0x05DFu);
    EXPECT_STREQ(config.digitiser.serial, "D-0007");
    EXPECT_STREQ(config.link.functionfs, "/run/gonio/ffs");
    EXPECT_TRUE(config.link.tcp);
    EXPECT_EQ(config.link.tcp_port, 0u);
    EXPECT_EQ(config.threads.motion_priority, 90);
    EXPECT_EQ(config.threads.stream_priority, 0);
    EXPECT_EQ(config.threads.motion_cpu, 3);
    EXPECT_STREQ(config.watchdog_device, "/dev/watchdog");
}

TEST(Config, the_words_for_nothing) {
    Parsed const parsed = parse("digitiser.serial = any\nlink.functionfs = none\nlink.tcp_port = 1\n"
                                "realtime.motion_cpu = any\nwatchdog.device = none\n");
    ASSERT_TRUE(parsed.good) << parsed.error;
    EXPECT_STREQ(parsed.config.digitiser.serial, "");
    EXPECT_STREQ(parsed.config.link.functionfs, "");
    EXPECT_EQ(parsed.config.link.tcp_port, 1u);
    EXPECT_EQ(parsed.config.threads.motion_cpu, -1);
    EXPECT_STREQ(parsed.config.watchdog_device, "");
}

struct Refusal {
    const char *text;
    const char *where;
    const char *says;
};

class Refused : public testing::TestWithParam<Refusal> {};

TEST_P(Refused, with_the_line_and_a_remedy) {
    Refusal const &one = GetParam();
    Parsed const parsed = parse(one.text);
    EXPECT_FALSE(parsed.good);
    EXPECT_EQ(parsed.error.rfind(one.where, 0), 0u) << parsed.error;
    EXPECT_NE(parsed.error.find(one.says), std::string::npos) << parsed.error;
    EXPECT_EQ(parsed.error.find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Config, Refused,
    testing::Values(Refusal{"\n\ncan.intreface = can0\n", "a.conf:3: ", "no setting is called 'can.intreface'"},
                    Refusal{"can.interface\n", "a.conf:1: ", "write key = value"},
                    Refusal{"can.interface =\n", "a.conf:1: can.interface: ", "e.g. can0"},
                    Refusal{"can.interface = a-name-that-is-too-long\n", "a.conf:1: can.interface: ", "e.g. can0"},
                    Refusal{"can.interface = can 0\n", "a.conf:1: can.interface: ", "e.g. can0"},
                    Refusal{"can.interface = can0\n\ncan.interface = can1\n", "a.conf:3: ", "stands in line 1 already"},
                    Refusal{"can.sync_stamp_sigma_us = -1\n", "a.conf:1: ", "0 to 10000"},
                    Refusal{"can.sync_stamp_sigma_us = nan\n", "a.conf:1: ", "0 to 10000"},
                    Refusal{"can.sync_stamp_sigma_us = 1.5.2\n", "a.conf:1: ", "0 to 10000"},
                    Refusal{"input.strobe = 4\n", "a.conf:1: input.strobe: ", "CHIP:OFFSET"},
                    Refusal{"input.strobe = gpiochip0:\n", "a.conf:1: input.strobe: ", "CHIP:OFFSET"},
                    Refusal{"input.strobe = a:b:4\n", "a.conf:1: input.strobe: ", "CHIP:OFFSET"},
                    Refusal{"input.strobe = :4\n", "a.conf:1: input.strobe: ", "CHIP:OFFSET"},
                    Refusal{"input.strobe = gpiochip0:1024\n", "a.conf:1: input.strobe: ", "CHIP:OFFSET"},
                    Refusal{"input.strobe = gpiochip0:4 active-high\n", "a.conf:1: input.strobe: ", "active-low"},
                    Refusal{"input.strobe = gpiochip0:4active-low\n", "a.conf:1: input.strobe: ", "active-low"},
                    Refusal{"gpio.event_buffer = 8\n", "a.conf:1: ", "16 to 1024"},
                    Refusal{"gpio.event_buffer = 0x40\n", "a.conf:1: ", "16 to 1024"},
                    Refusal{"digitiser.usb_id = 1209:2\n", "a.conf:1: ", "1209:0002"},
                    Refusal{"digitiser.usb_id = 1209:000g\n", "a.conf:1: ", "1209:0002"},
                    Refusal{"link.functionfs = ffs\n", "a.conf:1: ", "absolute"},
                    Refusal{"link.tcp_port = 0\n", "a.conf:1: ", "1 to 65535"},
                    Refusal{"link.tcp_port = 65536\n", "a.conf:1: ", "1 to 65535"},
                    Refusal{"link.tcp_port = none\nlink.functionfs = none\n", "a.conf:2: ", "no host could connect"},
                    Refusal{"realtime.motion_priority = 99\n", "a.conf:1: ", "1 to 98"},
                    Refusal{"realtime.motion_priority = -1\n", "a.conf:1: ", "1 to 98"},
                    Refusal{"realtime.motion_cpu = 1024\n", "a.conf:1: ", "processor"},
                    Refusal{"device.name = \x1b[31mred\n", "a.conf:1: device.name: cannot use '?[31mred'", "letters"}));

TEST(Config, a_zero_byte_is_no_end_of_a_value) {
    Parsed const parsed = parse(std::string("can.interface = can0\0x\n", 23));
    EXPECT_FALSE(parsed.good);
    EXPECT_EQ(parsed.error.rfind("a.conf:1: can.interface: cannot use 'can0?x'", 0), 0u) << parsed.error;
}

TEST(Config, a_file_that_is_not_there_is_named) {
    gn_config config;
    char error[256] = "";
    gn_config_defaults(&config);
    EXPECT_FALSE(gn_config_load(&config, "/nonexistent/goniod.conf", error, sizeof error));
    EXPECT_EQ(std::string(error), "/nonexistent/goniod.conf: No such file or directory; name the settings file with "
                                  "--config FILE");
}

// The packaged file says what the defaults are, for whoever reads it.
TEST(Config, the_installed_file_names_every_setting_with_its_default) {
    std::string const path = GONIO_SOURCE_DIR "/packaging/goniod.conf";
    gn_config defaults;
    gn_config installed;
    char error[256] = "";
    gn_config_defaults(&defaults);
    gn_config_defaults(&installed);
    ASSERT_TRUE(gn_config_load(&installed, path.c_str(), error, sizeof error)) << error;
    EXPECT_STREQ(installed.can.interface, defaults.can.interface);
    EXPECT_EQ(installed.link.tcp_port, defaults.link.tcp_port);
    std::ifstream file(path);
    std::stringstream whole;
    whole << file.rdbuf();
    for (const char *key : {"device.name",
                            "can.interface",
                            "can.sync_stamp_sigma_us",
                            "input.strobe",
                            "input.door",
                            "input.emergency_stop",
                            "input.sto",
                            "input.limit",
                            "output.shutter",
                            "output.lamp",
                            "output.watchdog",
                            "gpio.event_buffer",
                            "digitiser.usb_id",
                            "digitiser.serial",
                            "link.functionfs",
                            "link.tcp_port",
                            "realtime.motion_priority",
                            "realtime.stream_priority",
                            "realtime.motion_cpu",
                            "watchdog.device"}) {
        EXPECT_NE(whole.str().find("\n" + std::string(key) + " = "), std::string::npos) << key;
    }
}

} // namespace
