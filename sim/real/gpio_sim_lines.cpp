// gpio_sim_lines.cpp: pulls inputs, looks at outputs.
#include "gpio_sim_lines.hpp"

#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <unistd.h>

#include "toml_table.hpp"

namespace gonio::sim {
namespace {

// Outputs have no event on this side of the chip. The watchdog is a level that changes each SYNC cycle or a pulse of a
// cycle's length; a shutter of 20 ms travel does not mind.
constexpr std::int64_t look_every_ns = 5000000;
enum Output : std::size_t { shutter, lamp, watchdog };

int open_file(const std::filesystem::path &chip, std::size_t offset, const char *name, int mode) {
    std::filesystem::path const path = chip / ("sim_gpio" + std::to_string(offset)) / name;
    int const file = open(path.c_str(), mode | O_CLOEXEC);
    if (file < 0) {
        throw Input_error("--gpio-sim " + path.string() + ": cannot be opened (" + std::strerror(errno) +
                          "); name the folder of a gpio-sim chip with 8 lines");
    }
    return file;
}

} // namespace

Gpio_sim_lines::Gpio_sim_lines(const std::filesystem::path &chip, Apparatus &apparatus) : apparatus_(apparatus) {
    pulls_.fill(-1);
    values_.fill(-1);
    for (std::uint32_t line = 0; line < pulls_.size(); ++line) {
        pulls_.at(line) = open_file(chip, line, "pull", O_WRONLY);
        set(line, apparatus.line_level(line));
    }
    for (std::size_t output = 0; output < values_.size(); ++output) {
        values_.at(output) = open_file(chip, pulls_.size() + output, "value", O_RDONLY);
    }
    look();
}

Gpio_sim_lines::~Gpio_sim_lines() {
    for (int const file : pulls_) {
        close(file);
    }
    for (int const file : values_) {
        close(file);
    }
}

void Gpio_sim_lines::set(std::uint32_t line, bool high) const {
    std::string const pull = high ? "pull-up\n" : "pull-down\n";
    if (pwrite(pulls_.at(line), pull.data(), pull.size(), 0) != static_cast<ssize_t>(pull.size())) {
        throw Input_error("--gpio-sim: line " + std::to_string(line) + " cannot be pulled (" + std::strerror(errno) +
                          "); is the chip still there?");
    }
}

void Gpio_sim_lines::look() {
    for (std::size_t output = 0; output < values_.size(); ++output) {
        char value = '0';
        bool const known = pread(values_.at(output), &value, 1, 0) == 1;
        bool const high = known && value == '1';
        if (high != high_.at(output)) {
            high_.at(output) = high;
            output_changed(output, high);
        }
    }
    apparatus_.scheduler().after(look_every_ns, [this] { look(); });
}

void Gpio_sim_lines::output_changed(std::size_t output, bool high) {
    if (output == shutter) {
        apparatus_.set_shutter(high);
    } else if (output == lamp) {
        apparatus_.set_lamp(high);
    } else {
        apparatus_.pulse_watchdog();
    }
}

} // namespace gonio::sim
