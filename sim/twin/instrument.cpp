// instrument.cpp: reads the instrument file.
#include "instrument.hpp"

#include "toml_table.hpp"

namespace gonio::sim {
namespace {

std::uint32_t count_of(Toml_table &table, const std::string &key) {
    std::int64_t const value = table.integer(key);
    if (value < 0 || value > UINT32_MAX) {
        table.fail(key, "is out of range");
    }
    return static_cast<std::uint32_t>(value);
}

Axis_settings read_axis(Toml_table table) {
    Axis_settings axis{};
    axis.name = table.text("name");
    axis.carries_sample = table.text("carries") == "sample";
    axis.vector = table.numbers<3>("vector", 0.0);
    axis.node = static_cast<std::uint8_t>(count_of(table, "node"));
    axis.counts_per_turn = count_of(table, "counts_per_turn");
    auto const ratio = table.numbers<2>("counts_per_deg", 0.0);
    axis.counts_per_deg = ratio[0] / ratio[1];
    axis.min_deg = table.number("min_deg");
    axis.max_deg = table.number("max_deg");
    axis.max_velocity_deg_per_s = table.number("max_velocity_deg_per_s");
    axis.max_acceleration_deg_per_s2 = table.number("max_acceleration_deg_per_s2");
    axis.brake = table.boolean("brake", false);
    axis.gravity = table.boolean("gravity", false);
    axis.following_error_deg = table.number("following_error_deg");
    axis.following_error_timeout_ms = count_of(table, "following_error_timeout_ms");
    axis.quick_stop_deg_per_s2 = table.number("quick_stop_deg_per_s2");
    Toml_table homing = table.table("homing");
    axis.homing = {static_cast<std::int32_t>(homing.integer("method")),
                   homing.number("fast_deg_per_s"),
                   homing.number("slow_deg_per_s"),
                   homing.number("acceleration_deg_per_s2"),
                   homing.number("switch_deg"),
                   count_of(homing, "order")};
    homing.finish();
    // The host's business: what it may do with the axis and how it corrects.
    table.ignore({"driven", "cable_wrap_deg", "encoder", "latch_delay_us", "latch_delay_u_us"});
    table.finish();
    return axis;
}

Cycle read_cycle(Toml_table table) {
    Cycle cycle{};
    cycle.sync_period_us = count_of(table, "sync_period_us");
    cycle.sync_window_us = count_of(table, "sync_window_us");
    cycle.firmware_heartbeat_ms = count_of(table, "firmware_heartbeat_ms");
    cycle.drive_heartbeat_ms = count_of(table, "drive_heartbeat_ms");
    cycle.heartbeat_timeout_ms = count_of(table, "heartbeat_timeout_ms");
    cycle.rpdo_deadline_syncs = count_of(table, "rpdo_deadline_syncs");
    cycle.sdo_timeout_ms = count_of(table, "sdo_timeout_ms");
    cycle.boot_timeout_ms = count_of(table, "boot_timeout_ms");
    cycle.expiry_ms = count_of(table, "expiry_ms");
    cycle.sample_period_us = count_of(table, "sample_period_us");
    cycle.samples_per_strobe = count_of(table, "samples_per_strobe");
    cycle.clock_settle_ms = count_of(table, "clock_settle_ms");
    cycle.edge_tolerance_percent = count_of(table, "edge_tolerance_percent");
    table.finish();
    return cycle;
}

} // namespace

Instrument load_instrument(const std::filesystem::path &path) {
    toml::table const root = parse_toml_file(path);
    Toml_table table(root, path.string());
    Toml_table general = table.table("instrument");
    Instrument instrument{};
    instrument.name = general.text("name");
    instrument.arm_radius_mm = general.number("arm_radius_mm");
    instrument.detector_aperture_mm = general.number("detector_aperture_mm");
    instrument.head_diameter_mm = general.number("head_diameter_mm");
    general.finish();
    instrument.cycle = read_cycle(table.table("cycle"));
    std::vector<Toml_table> const axes = table.tables("axis");
    if (axes.size() != axis_count) {
        table.fail("axis", "must be there four times: the twin has four drives");
    }
    for (std::size_t i = 0; i < axis_count; ++i) {
        instrument.axes.at(i) = read_axis(axes.at(i));
    }
    // The twin's arm may go where the planner must not; its channels are the scenario's, and it needs no calibration.
    table.ignore({"zone", "channel", "calibration"});
    table.finish();
    return instrument;
}

} // namespace gonio::sim
