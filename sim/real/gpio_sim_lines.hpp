// gpio_sim_lines.hpp: the lines of a gpio-sim chip, through the files that the kernel keeps for each of them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "apparatus.hpp"
#include "edge.h"

namespace gonio::sim {

// Offsets 0 to 4 are the firmware's inputs, numbered as enum gn_line: the twin pulls them. 5 to 7 are its outputs
// shutter, lamp and watchdog: the twin looks at them.
class Gpio_sim_lines {
public:
    // The chip's sysfs folder, which holds sim_gpio0 ... Throws Input_error if it does not.
    Gpio_sim_lines(const std::filesystem::path &chip, Apparatus &apparatus);
    ~Gpio_sim_lines();
    Gpio_sim_lines(const Gpio_sim_lines &) = delete;
    Gpio_sim_lines &operator=(const Gpio_sim_lines &) = delete;
    Gpio_sim_lines(Gpio_sim_lines &&) = delete;
    Gpio_sim_lines &operator=(Gpio_sim_lines &&) = delete;

    void set(std::uint32_t line, bool high) const;

private:
    static constexpr std::size_t output_count = 3;
    void look();
    void output_changed(std::size_t output, bool high);

    Apparatus &apparatus_;
    std::array<int, GN_LINE_COUNT> pulls_{};
    std::array<int, output_count> values_{};
    std::array<bool, output_count> high_{};
};

} // namespace gonio::sim
