// scenario.cpp: reads a scenario file and refuses what it does not know.
#include "scenario.hpp"

#include <cmath>
#include <map>
#include <numbers>

#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr double deg = std::numbers::pi / 180.0;

const std::map<std::string, Fault_kind> fault_kinds = {
    {"strobe_lost", Fault_kind::strobe_lost},
    {"strobe_extra", Fault_kind::strobe_extra},
    {"strobe_stuck", Fault_kind::strobe_stuck},
    {"strobe_doubled", Fault_kind::strobe_doubled},
    {"sync_lost", Fault_kind::sync_lost},
    {"tpdo_late", Fault_kind::tpdo_late},
    {"drive_misses_sync", Fault_kind::drive_misses_sync},
    {"packet_lost", Fault_kind::packet_lost},
    {"packet_counter_start", Fault_kind::packet_counter_start},
    {"node_silent", Fault_kind::node_silent},
    {"node_missing", Fault_kind::node_missing},
    {"emcy", Fault_kind::emcy},
    {"blocked", Fault_kind::blocked},
    {"sto_open", Fault_kind::sto_open},
    {"door_open", Fault_kind::door_open},
    {"limit", Fault_kind::limit},
    {"emergency_stop", Fault_kind::emergency_stop},
    {"host_silent", Fault_kind::host_silent},
};

double at_least(Toml_table &table, const std::string &key, double fallback, double least) {
    double const value = table.number(key, fallback);
    if (!(value >= least)) {
        table.fail(key, "must be at least " + std::to_string(least));
    }
    return value;
}

void read_component(Toml_table table, Sample &sample) {
    std::string const kind = table.text("kind");
    if (kind == "lambertian") {
        sample.lambertian.push_back(
            {at_least(table, "reflectance", 0.0, 0.0), at_least(table, "transmittance", 0.0, 0.0)});
    } else if (kind == "gaussian") {
        static const std::map<std::string, Lobe_axis> axes = {
            {"mirror", Lobe_axis::mirror}, {"retro", Lobe_axis::retro}, {"through", Lobe_axis::through}};
        auto const about = axes.find(table.text("about"));
        if (about == axes.end()) {
            table.fail("about", "must be mirror, retro or through");
        }
        double const sigma_deg = table.number("sigma_deg");
        if (!(sigma_deg >= 0.01 && sigma_deg <= 30.0)) {
            table.fail("sigma_deg", "must be from 0.01 to 30");
        }
        sample.lobes.push_back({about->second, sigma_deg, at_least(table, "integral", 1.0, 0.0)});
    } else if (kind == "straight-through") {
        sample.straight.push_back({at_least(table, "transmittance", 1.0, 0.0)});
    } else {
        table.fail("kind", "must be lambertian, gaussian or straight-through");
    }
    table.finish();
}

void read_beam(Toml_table table, Scenario &scenario) {
    std::string const kind = table.text("kind", "collimated");
    if (kind != "collimated" && kind != "focused") {
        table.fail("kind", "must be collimated or focused");
    }
    bool const collimated = kind == "collimated";
    double const radius_mm = scenario.instrument.arm_radius_mm;
    double const diameter_mm = at_least(table, "diameter_mm", collimated ? 65.0 : 10.0, 0.1);
    double const natural_deg = collimated ? 2.0 * std::atan(0.5 * diameter_mm / radius_mm) / deg : 1.0;
    double const divergence_deg = at_least(table, "divergence_deg", natural_deg, 0.01);
    double const edge_deg = at_least(table, "edge_deg", 0.1, 0.0);
    if (divergence_deg > 20.0 || edge_deg > divergence_deg) {
        table.fail("divergence_deg", "must be at most 20 and not less than edge_deg");
    }
    scenario.beam = {divergence_deg * deg, edge_deg * deg};
    scenario.beam_diameter_at_head_mm = std::max(diameter_mm, 2.0 * radius_mm * std::tan(0.5 * divergence_deg * deg));
    scenario.power_counts = at_least(table, "power_counts", 1500.0, 0.0);
    if (!scenario.photon_map.wanted) {
        table.finish();
    }
}

void read_sample(Toml_table table, Scenario &scenario) {
    scenario.sample_mounted = table.boolean("mounted", true);
    scenario.photon_map.wanted = table.has("kind");
    if (scenario.photon_map.wanted) {
        return;
    }
    for (Toml_table &component : table.tables("components")) {
        read_component(std::move(component), scenario.sample);
    }
    table.finish();
}

void read_photon_map(Toml_table &detector, Photon_map_settings &settings) {
    settings.band = detector.text("band", "");
    settings.memory_mib = at_least(detector, "map_memory_mib", settings.memory_mib, 1.0);
    settings.incident_tolerance_deg =
        at_least(detector, "incident_tolerance_deg", settings.incident_tolerance_deg, 0.005);
}

void read_detector(Toml_table table, Scenario &scenario) {
    Detector_config &d = scenario.detector;
    d.high_gain = at_least(table, "high_gain", d.high_gain, 0.0);
    d.full_scale_counts = static_cast<std::int32_t>(table.integer("full_scale_counts", d.full_scale_counts));
    d.noise_counts_rms = table.numbers<2>("noise_counts_rms", 0.0);
    d.shot_noise = at_least(table, "shot_noise", 0.0, 0.0);
    d.dark_counts = table.numbers<2>("dark_counts", 0.0);
    d.dark_drift_counts_per_s = table.numbers<2>("dark_drift_counts_per_s", 0.0);
    d.dark_counts_per_c = table.numbers<2>("dark_counts_per_c", 0.0);
    d.temperature_c = table.number("temperature_c", d.temperature_c);
    d.temperature_drift_c_per_s = table.number("temperature_drift_c_per_s", 0.0);
    d.monitor_counts = at_least(table, "monitor_counts", d.monitor_counts, 0.0);
    d.monitor_noise_counts_rms = at_least(table, "monitor_noise_counts_rms", 0.0, 0.0);
    d.lamp_drift_per_s = table.number("lamp_drift_per_s", 0.0);
    d.lamp_ripple = table.number("lamp_ripple", 0.0);
    d.lamp_ripple_period_s = at_least(table, "lamp_ripple_period_s", d.lamp_ripple_period_s, 0.001);
    scenario.high_delay_us = at_least(table, "high_delay_us", 0.0, 0.0);
    scenario.low_delay_us = at_least(table, "low_delay_us", 0.0, 0.0);
    if (scenario.photon_map.wanted) {
        read_photon_map(table, scenario.photon_map);
    }
    table.finish();
}

void read_timing(Toml_table table, Scenario &scenario) {
    scenario.timing.sync_jitter_us = at_least(table, "sync_jitter_us", 0.0, 0.0);
    scenario.timing.strobe_latency_us = at_least(table, "strobe_latency_us", 0.0, 0.0);
    scenario.timing.echo_latency_us = at_least(table, "echo_latency_us", 0.0, 0.0);
    Digitiser_config &d = scenario.digitiser;
    d.clock_error_ppm = table.number("digitiser_ppm", 0.0);
    d.start_delay_us = at_least(table, "start_delay_us", d.start_delay_us, 1.0);
    d.packet_latency_us = at_least(table, "packet_latency_us", d.packet_latency_us, 0.0);
    d.packet_samples = static_cast<std::uint32_t>(at_least(table, "packet_samples", d.packet_samples, 1.0));
    table.finish();
}

void read_drives(Toml_table table, Drives &drives) {
    std::vector<std::string> const personality = table.texts("personality");
    if (!personality.empty() && personality.size() != axis_count) {
        table.fail("personality", "needs four texts");
    }
    for (std::size_t i = 0; i < axis_count; ++i) {
        drives.personality.at(i) = personality.empty() ? "full" : personality.at(i);
        if (drives.personality.at(i) != "full" && drives.personality.at(i) != "basic" &&
            drives.personality.at(i) != "fixed") {
            table.fail("personality", "must be full, basic or fixed");
        }
    }
    for (const std::string &text : table.texts("without")) {
        auto const name = object_name(text);
        if (!name) {
            table.fail("without", "must list objects such as \"0x6007\" or \"0x1400:05\", not \"" + text + "\"");
        }
        drives.without.push_back(*name);
    }
    drives.latch_delay_us = table.numbers<axis_count>("latch_delay_us", 0.0);
    drives.initial_deg = table.numbers<axis_count>("initial_deg", 0.0);
    drives.inverted = table.booleans<axis_count>("inverted");
    table.finish();
}

void read_digitiser(Toml_table table, Scenario &scenario) {
    std::string const pattern = table.text("pattern", "light");
    if (pattern != "light" && pattern != "counter") {
        table.fail("pattern", "must be light or counter");
    }
    scenario.counter_pattern = pattern == "counter";
    table.finish();
}

Fault fault_of(Toml_table table) {
    auto const kind = fault_kinds.find(table.text("kind"));
    if (kind == fault_kinds.end()) {
        std::string known;
        for (const auto &[name, value] : fault_kinds) {
            known += (known.empty() ? "" : ", ") + name;
        }
        table.fail("kind", "must be one of " + known);
    }
    Fault fault{};
    fault.kind = kind->second;
    fault.at_s = at_least(table, "at_s", 0.0, 0.0);
    fault.after_path = static_cast<std::uint32_t>(at_least(table, "after_path", 0.0, 0.0));
    std::int64_t const axis = table.integer("axis", 0);
    if (axis < 0 || axis >= static_cast<std::int64_t>(axis_count)) {
        table.fail("axis", "must be 0 to 3");
    }
    fault.axis = static_cast<std::size_t>(axis);
    fault.count = static_cast<std::uint32_t>(at_least(table, "count", 1.0, 1.0));
    fault.counted = table.boolean("counted", true);
    fault.delay_us = at_least(table, "delay_us", 2500.0, 0.0);
    bool const emergency = fault.kind == Fault_kind::emcy;
    fault.value =
        static_cast<std::uint32_t>(at_least(table, emergency ? "code" : "value", emergency ? 0x4310 : 0, 0.0));
    table.finish();
    return fault;
}

} // namespace

Fault read_fault(const toml::table &table, const std::string &where) {
    return fault_of(Toml_table(table, where));
}

Scenario load_scenario(const std::filesystem::path &path, const std::filesystem::path &source_directory) {
    toml::table const root = parse_toml_file(path);
    Toml_table table(root, path.string());
    Scenario scenario{};
    scenario.path = path;
    scenario.eds_directory = source_directory / "protocol" / "eds";
    scenario.seed = static_cast<std::uint64_t>(table.integer("seed", 1));
    std::filesystem::path instrument = path.parent_path() / table.text("instrument", "axes.toml");
    if (!table.has("instrument") && !std::filesystem::exists(instrument)) {
        instrument = source_directory / "protocol" / "axes.toml";
    }
    scenario.instrument = load_instrument(instrument);
    read_sample(table.table("sample"), scenario);
    if (scenario.photon_map.wanted) {
        table.ignore({"materials", "source", "band", "photons", "readings", "rig"});
    }
    read_beam(table.table("beam"), scenario);
    read_detector(table.table("detector"), scenario);
    read_timing(table.table("timing"), scenario);
    read_digitiser(table.table("digitiser"), scenario);
    read_drives(table.table("drives"), scenario.drives);
    for (Toml_table &fault : table.tables("fault")) {
        scenario.faults.push_back(fault_of(std::move(fault)));
    }
    table.finish();
    return scenario;
}

} // namespace gonio::sim
