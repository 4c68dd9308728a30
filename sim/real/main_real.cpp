// main_real.cpp: gonio-twin-devices: the simulated instrument behind a real kernel's CAN, GPIO and USB, for goniod.
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

#include "can_raw.hpp"
#include "commands.hpp"
#include "control.hpp"
#include "gpio_sim_lines.hpp"
#include "journal.hpp"
#include "socketcand.hpp"
#include "tcp.hpp"
#include "toml_table.hpp"
#include "usb_digitiser.hpp"

namespace {

using namespace gonio::sim;

constexpr const char *usage =
    "usage: gonio-twin-devices SCENARIO.toml [--can IFACE|socketcand:127.0.0.1:PORT] [--gpio-sim DIR]"
    " [--digitiser FUNCTIONFS_DIR] [--control SOCKET] [--journal FILE.json] [--truth FILE]";

struct Options {
    std::string scenario;
    std::string can;
    std::string gpio_sim;
    std::string digitiser;
    std::string control;
    std::string journal;
    std::string truth;
};

std::atomic<bool> ended{false};

void on_signal(int) {
    ended = true;
}

Options parse(int argc, char **argv) {
    Options options;
    const std::map<std::string, std::string Options::*> known = {
        {"--can", &Options::can},         {"--gpio-sim", &Options::gpio_sim}, {"--digitiser", &Options::digitiser},
        {"--control", &Options::control}, {"--journal", &Options::journal},   {"--truth", &Options::truth}};
    for (int i = 1; i < argc; ++i) {
        std::string const word = argv[i];
        if (auto const option = known.find(word); option != known.end()) {
            if (i + 1 >= argc) {
                throw Input_error(word + " needs a value; " + usage);
            }
            options.*(option->second) = argv[++i];
        } else if (options.scenario.empty() && word.rfind("--", 0) != 0) {
            options.scenario = word;
        } else {
            throw Input_error("'" + word + "' is not known; " + usage);
        }
    }
    if (options.scenario.empty()) {
        throw Input_error(usage);
    }
    return options;
}

Scenario scenario_of(const Options &options) {
    const char *named = std::getenv("GONIO_SOURCE_DIR");
    Scenario scenario = load_scenario(options.scenario, named != nullptr ? named : GONIO_SOURCE_DIR);
    for (const Fault &fault : scenario.faults) {
        if (fault.after_path != 0 || fault.kind == Fault_kind::host_silent) {
            throw Input_error(options.scenario + ": a fault after a path, or of the host, needs gonio-twin;"
                                                 " ask for it by --control instead");
        }
    }
    return scenario;
}

std::unique_ptr<Can_wire> wire_of(const std::string &can, Scheduler &scheduler) {
    std::string const prefix = "socketcand:";
    if (can.empty()) {
        return nullptr;
    }
    if (can.rfind(prefix, 0) != 0) {
        return std::make_unique<Can_raw>(scheduler, can);
    }
    auto const [host, port] = parse_address("--can socketcand", can.substr(prefix.size()));
    auto wire = std::make_unique<Socketcand>(scheduler, host, port);
    std::cout << "listening " << host << ":" << wire->port() << std::endl;
    return wire;
}

int run(const Options &options) {
    std::unique_ptr<Gpio_sim_lines> lines;
    std::unique_ptr<Usb_digitiser> usb;
    auto const set_line = [&](std::uint32_t line, bool level) {
        if (lines) {
            lines->set(line, level);
        }
    };
    auto const packet = [&] {
        if (usb) {
            usb->pump();
        }
    };
    Apparatus apparatus(scenario_of(options), options.truth, closed_form_optics,
                        {set_line, {}, [&](bool high) { set_line(GN_LINE_STROBE, high); }, packet, {}},
                        {monotonic_ns(), Can_bus::no_bit_times, true});
    apparatus.arm_faults();
    Event_loop loop(apparatus.scheduler());
    std::unique_ptr<Can_wire> const wire = wire_of(options.can, apparatus.scheduler());
    std::unique_ptr<Can_bridge> bridge;
    if (wire) {
        bridge = std::make_unique<Can_bridge>(apparatus.scheduler(), apparatus.bus(), *wire);
        loop.add(*wire);
    }
    if (!options.gpio_sim.empty()) {
        lines = std::make_unique<Gpio_sim_lines>(options.gpio_sim, apparatus);
    }
    if (!options.digitiser.empty()) {
        usb = std::make_unique<Usb_digitiser>(open_functionfs(options.digitiser), apparatus.digitiser());
        loop.add(*usb);
    }
    Furthest furthest;
    Commands commands(apparatus, wire.get(), furthest, ended);
    std::unique_ptr<Control_socket> control;
    if (!options.control.empty()) {
        control = std::make_unique<Control_socket>(options.control,
                                                   [&](const std::string &line) { return commands.obey(line); });
        loop.add(*control);
    }
    loop.on_turn = [&] { furthest.see(apparatus.position_deg(apparatus.scheduler().now_ns())); };
    std::cout << "serving" << std::endl;
    loop.run(ended);
    if (!options.journal.empty()) {
        write_journal(options.journal, apparatus, "asked to end");
    }
    return 0;
}

} // namespace

int main(int argc, char **argv) {
    std::signal(SIGTERM, on_signal);
    std::signal(SIGINT, on_signal);
    try {
        return run(parse(argc, argv));
    } catch (const std::exception &error) {
        std::cerr << "gonio-twin-devices: " << error.what() << std::endl;
        return 2;
    }
}
