// scenario.hpp: a scenario file: the sample, the light, the detector, timing, drives and faults of one simulated run.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "closed_form.hpp"
#include "detector.hpp"
#include "digitiser.hpp"
#include "eds.hpp"
#include "instrument.hpp"

namespace gonio::sim {

enum class Fault_kind {
    strobe_lost,          // count, counted
    strobe_extra,         // a spurious pulse
    strobe_stuck,         // the line stays high
    strobe_doubled,       // count: pulses that come twice
    sync_lost,            // count
    tpdo_late,            // axis, delay_us, count
    drive_misses_sync,    // axis
    packet_lost,          // count
    packet_counter_start, // value; from the start
    node_silent,          // axis
    node_missing,         // axis; from the start
    emcy,                 // axis, code
    blocked,              // axis
    sto_open,
    door_open,
    limit, // the line of the limit switches drops
    emergency_stop,
    host_silent,
};

struct Fault {
    Fault_kind kind;
    double at_s;              // from power-up, or after path number `after_path` (from 1) began to move
    std::uint32_t after_path; // 0: from power-up
    std::size_t axis;         // 0..3
    std::uint32_t count;
    bool counted; // lost edges show in the kernel's numbers
    double delay_us;
    std::uint32_t value; // code of the EMCY, or the counter's start
};

struct Timing {
    double sync_jitter_us;    // the real-time thread wakes late by up to this
    double strobe_latency_us; // mean of the one-sided exponential
    double echo_latency_us;   // the same for the receive stamps of CAN frames
};

struct Drives {
    std::array<std::string, axis_count> personality;
    std::vector<Object_name> without; // objects that no drive has
    std::array<double, axis_count> latch_delay_us;
    std::array<double, axis_count> initial_deg;
    std::array<bool, axis_count> inverted; // the motor turns the other way: wrong wiring
};

// How the running twin reads a sample that is traced ([sample] kind); what is traced is the photon map's to read.
struct Photon_map_settings {
    bool wanted = false;                  // otherwise the sample is a closed form
    std::string band;                     // what the detector sees; empty: the file's first
    double memory_mib = 1024.0;           // of stored maps together
    double incident_tolerance_deg = 0.02; // a stored map answers for incident directions this near
};

struct Scenario {
    std::filesystem::path path;
    std::filesystem::path eds_directory;
    std::uint64_t seed;
    Instrument instrument;
    Sample sample; // empty if the photon map is wanted
    Photon_map_settings photon_map;
    bool sample_mounted;
    Beam_profile beam;
    double beam_diameter_at_head_mm;
    double power_counts; // low-gain counts for an apparent DSF of 1/sr
    Detector_config detector;
    double high_delay_us; // the value belongs to the light this long before the sample's time
    double low_delay_us;
    Timing timing;
    Digitiser_config digitiser;
    bool counter_pattern; // in place of light: the sample's number (mod 2^23) in its high channel
    Drives drives;
    std::vector<Fault> faults;
};

// A [[fault]] table; `where` names it in errors.
Fault read_fault(const toml::table &table, const std::string &where);

// Unknown keys and impossible values throw Input_error; of a photon map's scenario the keys of [sample], [beam] and the
// tables that only it has are left to its own reader. The instrument file is the one that the scenario names
// (relative to it), else axes.toml beside the scenario, else protocol/axes.toml under source_directory.
Scenario load_scenario(const std::filesystem::path &path, const std::filesystem::path &source_directory);

} // namespace gonio::sim
