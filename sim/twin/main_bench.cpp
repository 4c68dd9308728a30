// main_bench.cpp: gonio-twin-bench: boot, homing and a flight of 100,000 samples with firmware and twin alone; prints
// one JSON object.
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>

#include "bench_host.hpp"
#include "bench_report.hpp"
#include "world.hpp"

namespace {

using namespace gonio::sim;

constexpr std::int64_t longest_virtual_ns = 3600000000000; // whatever takes longer will never end

double cpu_s() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

int run(const std::filesystem::path &scenario_path, std::uint64_t samples) {
    Scenario const scenario = load_scenario(scenario_path, GONIO_SOURCE_DIR);
    Bench_host host(scenario.instrument, samples);
    World world(scenario, host, {});
    host.connect(world);
    auto wall = std::chrono::steady_clock::now();
    double cpu = cpu_s();
    auto const wall_start = wall;
    bool flying = false;
    while (!host.finished() && world.scheduler().run_one(longest_virtual_ns)) {
        if (!flying && host.result().flight_start_ns > 0) {
            flying = true;
            wall = std::chrono::steady_clock::now();
            cpu = cpu_s();
        }
    }
    auto const end = std::chrono::steady_clock::now();
    const Bench_result &result = host.result();
    std::cout << "{" << flight_members(result) << ", \"wall_s\": " << std::chrono::duration<double>(end - wall).count()
              << ", \"cpu_s\": " << cpu_s() - cpu
              << ", \"whole_wall_s\": " << std::chrono::duration<double>(end - wall_start).count()
              << ", \"whole_virtual_s\": " << 1e-9 * static_cast<double>(world.scheduler().now_ns())
              << ", \"can_frames\": " << world.apparatus().bus().frames() << "}" << std::endl;
    return result.finished && result.trouble.empty() ? 0 : 3;
}

} // namespace

int main(int argc, char **argv) {
    try {
        std::filesystem::path const scenario = argc > 1 ? argv[1] : GONIO_SOURCE_DIR "/sim/scenarios/demo.toml";
        return run(scenario, argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 100000);
    } catch (const std::exception &error) {
        std::cerr << "gonio-twin-bench: " << error.what() << std::endl;
        return 2;
    }
}
