// test_gpio_sim_lines.cpp: the files of a gpio-sim chip, played by a folder of ordinary files.
#include <gtest/gtest.h>

#include "gpio_sim_lines.hpp"
#include "real_bench.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

struct Chip {
    Chip() {
        std::filesystem::remove_all(path);
        for (int line = 0; line < 8; ++line) {
            std::filesystem::path const folder = path / ("sim_gpio" + std::to_string(line));
            std::filesystem::create_directories(folder);
            std::ofstream(folder / "pull") << "none";
            std::ofstream(folder / "value") << "0\n";
        }
    }
    ~Chip() { std::filesystem::remove_all(path); }
    Chip(const Chip &) = delete;
    Chip &operator=(const Chip &) = delete;
    // The kernel sees one write; the file keeps the rest of a longer one before.
    [[nodiscard]] std::string pull(int line) const {
        std::ifstream file(path / ("sim_gpio" + std::to_string(line)) / "pull");
        std::string text;
        std::getline(file, text);
        return text;
    }
    void put(int line, bool high) const {
        std::ofstream(path / ("sim_gpio" + std::to_string(line)) / "value") << (high ? "1\n" : "0\n");
    }
    std::filesystem::path path = std::filesystem::path(testing::TempDir()) / ("gpio_sim_" + std::to_string(getpid()));
};

} // namespace

TEST(Gpio_sim_lines, InputsAreStrobeDoorStopStoAndLimitInThisOrder) {
    Chip const chip;
    Real_bench bench;
    Gpio_sim_lines const lines(chip.path, bench.apparatus);
    EXPECT_EQ(chip.pull(0), "pull-down") << "strobe";
    for (int line = 1; line <= 4; ++line) {
        EXPECT_EQ(chip.pull(line), "pull-up") << line << ": closed, released, allowed, free";
    }
    lines.set(GN_LINE_STROBE, true);
    EXPECT_EQ(chip.pull(0), "pull-up");
    lines.set(GN_LINE_DOOR, false);
    EXPECT_EQ(chip.pull(1), "pull-down");
    lines.set(GN_LINE_LIMIT, false);
    EXPECT_EQ(chip.pull(4), "pull-down");
    EXPECT_EQ(chip.pull(2), "pull-up");
}

TEST(Gpio_sim_lines, OutputsOpenTheShutterLightTheLampAndKeepTheWatchdogQuiet) {
    Chip const chip;
    Real_bench bench;
    Gpio_sim_lines const lines(chip.path, bench.apparatus);
    chip.put(6, true);
    bench.run_ms(6);
    EXPECT_TRUE(bench.apparatus.lamp_on());
    chip.put(5, true);
    bench.run_ms(60);
    EXPECT_TRUE(bench.apparatus.dark()) << "nobody moves the watchdog";
    bool level = false;
    for (int cycle = 0; cycle < 20; ++cycle) {
        chip.put(7, level = !level);
        bench.run_ms(10);
    }
    EXPECT_FALSE(bench.apparatus.dark());
    bench.run_ms(150);
    EXPECT_TRUE(bench.apparatus.dark());
    EXPECT_EQ(bench.apparatus.shutter().watchdog_trips(), 1U);
    chip.put(6, false);
    bench.run_ms(6);
    EXPECT_FALSE(bench.apparatus.lamp_on());
}

TEST(Gpio_sim_lines, AFolderThatIsNoChipIsRefusedByName) {
    Real_bench bench;
    try {
        Gpio_sim_lines const lines("/nonexistent/gpiochip7", bench.apparatus);
        FAIL();
    } catch (const Input_error &error) {
        EXPECT_NE(std::string(error.what()).find("/nonexistent/gpiochip7"), std::string::npos);
    }
}

} // namespace gonio::sim
