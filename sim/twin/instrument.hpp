// instrument.hpp: the instrument file (protocol/axes.toml) as the twin needs it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "optics.hpp"

namespace gonio::sim {

inline constexpr std::size_t axis_count = 4;

struct Homing_settings {
    std::int32_t method;
    double fast_deg_per_s;
    double slow_deg_per_s;
    double acceleration_deg_per_s2;
    double switch_deg;
    std::uint32_t order;
};

struct Axis_settings {
    std::string name;
    bool carries_sample; // otherwise the detector
    Vec3 vector;
    std::uint8_t node;
    std::uint32_t counts_per_turn;
    double counts_per_deg;
    double min_deg;
    double max_deg;
    double max_velocity_deg_per_s;
    double max_acceleration_deg_per_s2;
    bool brake;
    bool gravity;
    double following_error_deg;
    std::uint32_t following_error_timeout_ms;
    double quick_stop_deg_per_s2;
    Homing_settings homing;
};

struct Cycle {
    std::uint32_t sync_period_us;
    std::uint32_t sync_window_us;
    std::uint32_t firmware_heartbeat_ms;
    std::uint32_t drive_heartbeat_ms;
    std::uint32_t heartbeat_timeout_ms;
    std::uint32_t rpdo_deadline_syncs;
    std::uint32_t sdo_timeout_ms;
    std::uint32_t boot_timeout_ms;
    std::uint32_t expiry_ms;
    std::uint32_t sample_period_us;
    std::uint32_t samples_per_strobe;
    std::uint32_t clock_settle_ms;
    std::uint32_t edge_tolerance_percent;
};

struct Instrument {
    std::string name;
    double arm_radius_mm;
    double detector_aperture_mm;
    double head_diameter_mm;
    Cycle cycle;
    std::array<Axis_settings, axis_count> axes;
};

// Throws Input_error.
Instrument load_instrument(const std::filesystem::path &path);

} // namespace gonio::sim
