// main.cpp: gonio-twin: a simulated instrument behind loopback TCP.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <string>

#include "journal.hpp"
#include "lockstep_link.hpp"
#include "run.hpp"
#include "toml_table.hpp"

#ifdef GONIO_PHOTON_MAP
#include "photon_map.hpp"
#endif

namespace {

using namespace gonio::sim;

constexpr const char *usage =
    "usage: gonio-twin SCENARIO.toml --virtual|--paced [--listen 127.0.0.1:PORT] [--truth FILE] [--journal FILE.json]"
    " [--patience-s SECONDS]";

struct Options {
    std::filesystem::path scenario;
    bool paced = false;
    std::string host = "127.0.0.1";
    std::uint16_t port = 0;
    std::filesystem::path truth;
    std::filesystem::path journal;
    double patience_s = 60.0;
};

std::atomic<bool> ended{false};

void on_signal(int) {
    ended = true;
}

std::uint16_t port_of(const std::string &text) {
    std::size_t used = 0;
    unsigned long value = 65536;
    try {
        value = std::stoul(text, &used);
    } catch (const std::logic_error &) {
        used = 0;
    }
    if (used == 0 || used != text.size() || value > 65535) {
        throw Input_error("--listen: '" + text + "' is no port; write 127.0.0.1:PORT, PORT from 0 to 65535");
    }
    return static_cast<std::uint16_t>(value);
}

void listen_at(const std::string &address, Options &options) {
    auto const colon = address.rfind(':');
    if (colon == std::string::npos) {
        throw Input_error("--listen: '" + address + "' is no address; write 127.0.0.1:PORT");
    }
    options.host = address.substr(0, colon);
    options.port = port_of(address.substr(colon + 1));
}

Options parse(int argc, char **argv) {
    Options options;
    bool mode_given = false;
    for (int i = 1; i < argc; ++i) {
        std::string const word = argv[i];
        auto const value = [&]() -> std::string {
            if (i + 1 >= argc) {
                throw Input_error(word + " needs a value; " + usage);
            }
            return argv[++i];
        };
        if (word == "--virtual" || word == "--paced") {
            options.paced = word == "--paced";
            mode_given = true;
        } else if (word == "--listen") {
            listen_at(value(), options);
        } else if (word == "--truth") {
            options.truth = value();
        } else if (word == "--journal") {
            options.journal = value();
        } else if (word == "--patience-s") {
            options.patience_s = std::strtod(value().c_str(), nullptr);
        } else if (options.scenario.empty() && word.rfind("--", 0) != 0) {
            options.scenario = word;
        } else {
            throw Input_error("'" + word + "' is not known; " + usage);
        }
    }
    if (options.scenario.empty() || !mode_given) {
        throw Input_error(usage);
    }
    return options;
}

std::filesystem::path source_directory() {
    const char *named = std::getenv("GONIO_SOURCE_DIR");
    return named != nullptr ? named : GONIO_SOURCE_DIR;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Without a photon map the closed forms' factory says what is missing.
std::unique_ptr<Optics> optics_of(const Scenario &scenario, [[maybe_unused]] bool paced) {
#ifdef GONIO_PHOTON_MAP
    if (scenario.photon_map.wanted) {
        const Photon_map_settings &map = scenario.photon_map;
        // In real time nobody should wait for the directions that the scenario names.
        return photon_map_optics(
            {scenario.path, source_directory(), map.band, map.memory_mib, map.incident_tolerance_deg, paced},
            [](const std::string &line) { std::cerr << line << std::endl; });
    }
#endif
    return closed_form_optics(scenario);
}

int run(const Options &options) {
    Scenario const scenario = load_scenario(options.scenario, source_directory());
    Lockstep_link link(options.host, options.port, options.paced);
    World world(scenario, link, options.truth,
                [&](const Scenario &wanted) { return optics_of(wanted, options.paced); });
    std::cout << "listening " << link.address() << std::endl;
    auto const start = std::chrono::steady_clock::now();
    std::string reason;
    int status = 0;
    try {
        reason = options.paced ? run_paced(world, link, ended) : run_virtual(world, link, options.patience_s, ended);
    } catch (const Stalled &stalled) {
        reason = stalled.what();
        std::cerr << "gonio-twin: " << reason << std::endl;
        status = 3;
    }
    if (!options.journal.empty()) {
        write_journal(options.journal, world, reason, seconds_since(start));
    }
    return status;
}

} // namespace

int main(int argc, char **argv) {
    std::signal(SIGTERM, on_signal);
    std::signal(SIGINT, on_signal);
    try {
        return run(parse(argc, argv));
    } catch (const std::exception &error) {
        std::cerr << "gonio-twin: " << error.what() << std::endl;
        return 2;
    }
}
