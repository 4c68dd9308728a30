// main_bench_host.cpp: gonio-bench-host: flies a path on a firmware behind loopback TCP, in real time; prints one JSON
// object with its counters and how late its threads woke up.
#include <array>
#include <chrono>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <string>
#include <utility>

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "bench_dialogue.hpp"
#include "bench_report.hpp"
#include "event_loop.hpp"
#include "scenario.hpp"
#include "tcp.hpp"
#include "toml_table.hpp"

namespace {

using namespace gonio::sim;

constexpr const char *usage = "usage: gonio-bench-host SCENARIO.toml --connect 127.0.0.1:PORT [--samples N]";
constexpr std::int64_t alive_every_ns = 100000000;    // the firmware begins to stop 0.7 s after the last word
constexpr std::int64_t last_account_ns = 2500000000;  // counters and latency come once per second
constexpr std::int64_t setup_limit_ns = 180000000000; // boot and homing, also under emulation
constexpr double flight_limit = 4.0;                  // times the flight's own duration
constexpr std::size_t chunk_bytes = 1U << 16U;

struct Options {
    std::string scenario;
    std::string address;
    std::uint64_t samples = 100000;
};

Options parse(int argc, char **argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        std::string const word = argv[i];
        bool const takes_value = word == "--connect" || word == "--samples";
        if (takes_value && i + 1 >= argc) {
            throw Input_error(word + " needs a value; " + usage);
        }
        if (word == "--connect") {
            options.address = argv[++i];
        } else if (word == "--samples") {
            options.samples = std::strtoull(argv[++i], nullptr, 10);
        } else if (options.scenario.empty() && word.rfind("--", 0) != 0) {
            options.scenario = word;
        } else {
            throw Input_error("'" + word + "' is not known; " + usage);
        }
    }
    if (options.scenario.empty() || options.address.empty() || options.samples == 0) {
        throw Input_error(usage);
    }
    return options;
}

// Says and hears until end_ns or until `done`.
template <typename Done> void converse(Bench_dialogue &dialogue, int socket, std::int64_t end_ns, Done done) {
    std::vector<std::uint8_t> chunk(chunk_bytes);
    std::int64_t said_ns = monotonic_ns();
    while (!done() && monotonic_ns() < end_ns) {
        pollfd readable{socket, POLLIN, 0};
        if (poll(&readable, 1, static_cast<int>(alive_every_ns / 1000000)) > 0) {
            ssize_t const length = recv(socket, chunk.data(), chunk.size(), MSG_DONTWAIT);
            if (length == 0) {
                dialogue.lost("the firmware closed the link");
                return;
            }
            if (length > 0) {
                dialogue.hear(chunk.data(), static_cast<std::size_t>(length));
            }
        }
        if (monotonic_ns() - said_ns >= alive_every_ns) {
            said_ns = monotonic_ns();
            dialogue.say_empty(GN_FRAME_ALIVE);
        }
    }
}

int run(const Options &options) {
    const char *named = std::getenv("GONIO_SOURCE_DIR");
    Scenario const scenario = load_scenario(options.scenario, named != nullptr ? named : GONIO_SOURCE_DIR);
    auto const [host, port] = parse_address("--connect", options.address);
    int const socket = connect_tcp("--connect", host, port);
    Bench_dialogue dialogue(scenario.instrument, options.samples, [socket](const std::vector<std::uint8_t> &frame) {
        // A few kilobytes per second: a socket that does not take them leads nowhere.
        if (send(socket, frame.data(), frame.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(frame.size())) {
            throw Input_error("--connect: the firmware does not take what is said to it; see its log");
        }
    });
    double const flight_ns = 1e3 * scenario.instrument.cycle.sample_period_us * static_cast<double>(options.samples);
    std::int64_t const start_ns = monotonic_ns();
    dialogue.begin();
    converse(dialogue, socket, start_ns + setup_limit_ns + static_cast<std::int64_t>(flight_limit * flight_ns),
             [&] { return dialogue.finished(); });
    if (!dialogue.finished()) {
        dialogue.lost("not finished in time");
    }
    if (dialogue.result().trouble.empty()) {
        converse(dialogue, socket, monotonic_ns() + last_account_ns, [] { return false; });
    }
    close(socket);
    const Bench_result &result = dialogue.result();
    std::cout << "{" << flight_members(result)
              << ", \"whole_wall_s\": " << 1e-9 * static_cast<double>(monotonic_ns() - start_ns)
              << ", \"counters\": " << counters_json(result.counters)
              << ", \"latency\": " << latency_json(result.latency) << "}" << std::endl;
    return result.finished && result.trouble.empty() ? 0 : 3;
}

} // namespace

int main(int argc, char **argv) {
    try {
        return run(parse(argc, argv));
    } catch (const std::exception &error) {
        std::cerr << "gonio-bench-host: " << error.what() << std::endl;
        return 2;
    }
}
