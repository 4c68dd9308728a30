// photon_map.cpp: from a scenario file to optics that trace it.
#include "photon_map.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include "photon_optics.hpp"
#include "rig_scenario.hpp"
#include "toml_table.hpp"
#include "virtual_goniophotometer.hpp"

namespace gonio::sim {
namespace {

constexpr double bytes_per_mib = 1048576.0;

std::string named(const Incident &incident, bool mounted) {
    if (!mounted) {
        return "the free beam";
    }
    char text[64];
    std::snprintf(text, sizeof text, "incident (%.4g, %.4g)", incident.theta_deg, incident.phi_deg);
    return text;
}

const Band &band_of(const Photon_scenario &scenario, const std::string &name) {
    if (name.empty()) {
        return scenario.bands.front();
    }
    for (const Band &band : scenario.bands) {
        if (band.name == name) {
            return band;
        }
    }
    std::string known;
    for (const Band &band : scenario.bands) {
        known += (known.empty() ? "" : ", ") + band.name;
    }
    throw Input_error(scenario.path.string() + " [detector]: 'band' must be one of the file's: " + known);
}

void check_memory(const Photon_scenario &scenario, double memory_mib) {
    double const most_mib = static_cast<double>(scenario.photons) * sizeof(Stored_hit) / bytes_per_mib;
    if (most_mib > memory_mib) {
        throw Input_error(scenario.path.string() + " [photons]: a map of so many may need " +
                          std::to_string(std::lround(most_mib)) +
                          " MiB; lower 'count' or raise map_memory_mib in [detector]");
    }
}

} // namespace

std::unique_ptr<Optics> photon_map_optics(const Photon_map_request &request,
                                          const std::function<void(const std::string &)> &say) {
    Photon_scenario const scenario = load_rig_scenario(request.scenario, request.source_directory, {});
    check_memory(scenario, request.memory_mib);
    Photon_optics_settings settings;
    settings.aperture_half_angle_rad = std::atan(0.5 * scenario.receiver.aperture_mm / scenario.receiver.radius_mm);
    settings.incident_tolerance_deg = request.incident_tolerance_deg;
    settings.memory_bytes = static_cast<std::size_t>(bytes_per_mib * request.memory_mib);
    Map_maker make_map = [scenario, band = band_of(scenario, request.band), say](const Incident &incident,
                                                                                 bool mounted) {
        std::string const what = named(incident, mounted);
        say("photon map: tracing " + what + ", " + std::to_string(scenario.photons) + " photons");
        auto const start = std::chrono::steady_clock::now();
        Watch watch;
        Virtual_goniophotometer const bench(scenario, band, incident, mounted);
        auto stored = bench.store({0, scenario.photons}, std::max(1U, std::thread::hardware_concurrency()), watch);
        char took[32];
        std::snprintf(took, sizeof took, "%.1f s",
                      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        say("photon map: " + what + " is ready, " + took);
        return std::move(stored.map);
    };
    auto optics = std::make_unique<Photon_optics>(std::move(make_map), settings);
    if (request.prepare) {
        optics->prepare(scenario.incidents);
    }
    return optics;
}

} // namespace gonio::sim
