// written_scenario.hpp: scenarios as text, written to a file and loaded as any other.
#pragma once

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <unistd.h>

#include "photon_scenario.hpp"
#include "virtual_goniophotometer.hpp"

namespace gonio::sim::test {

inline Photon_scenario written_scenario(const std::string &text) {
    static std::atomic<int> number{0};
    std::filesystem::path const path =
        std::filesystem::temp_directory_path() /
        ("gonio_" + std::to_string(::getpid()) + "_" + std::to_string(number++) + ".toml");
    std::ofstream(path) << text;
    Photon_scenario scenario = load_photon_scenario(path, GONIO_SOURCE_DIR, {});
    std::filesystem::remove(path);
    return scenario;
}

// The louver of papers [1] and [4] with these materials.
inline std::string louver(const std::string &top, const std::string &bottom, const std::string &keys = "") {
    return "seed = 5\n[sample]\nkind = \"louver\"\ntop = \"top\"\nbottom = \"bottom\"\n" + keys +
           "\n[materials.top]\n" + top + "\n[materials.bottom]\n" + bottom + "\n";
}

inline Virtual_goniophotometer at(const Photon_scenario &scenario, double theta_deg, double phi_deg,
                                  Walk walk = Walk::automatic) {
    return {scenario, scenario.bands.front(), {theta_deg, phi_deg}, true, walk};
}

inline Vector direction(double theta_deg, double phi_deg) {
    constexpr double rad_per_deg = std::numbers::pi / 180.0;
    double const sine = std::sin(theta_deg * rad_per_deg);
    return {sine * std::cos(phi_deg * rad_per_deg), sine * std::sin(phi_deg * rad_per_deg),
            std::cos(theta_deg * rad_per_deg)};
}

} // namespace gonio::sim::test
