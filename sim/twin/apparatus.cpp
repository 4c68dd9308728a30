// apparatus.cpp: joins the devices with the light.
#include "apparatus.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "edge.h"

namespace gonio::sim {
namespace {

constexpr double gravity_counts_per_s2 = -4.0e5;           // of the free arm: downwards
constexpr std::uint64_t counter_pattern_modulo = 1U << 23; // fits the converter's 24 bits, sign included

// Nothing lies behind an axis's switch; the homing's index pulse is where the instrument file says.
Drive_config drive_config(const Scenario &scenario, std::size_t i, bool in_step) {
    const Axis_settings &axis = scenario.instrument.axes.at(i);
    Drive_config config;
    config.node = axis.node;
    config.name = axis.name;
    config.eds_directory = scenario.eds_directory;
    config.personality = scenario.drives.personality.at(i);
    config.without = scenario.drives.without;
    config.counts_per_turn = axis.counts_per_turn;
    config.serial = static_cast<std::uint32_t>(1000 + i);
    config.initial_position_counts = scenario.drives.initial_deg.at(i) * axis.counts_per_deg;
    config.negative_switch_counts = axis.homing.switch_deg * axis.counts_per_deg;
    config.latch_delay_us = scenario.drives.latch_delay_us.at(i);
    config.brake = axis.brake;
    config.gravity_counts_per_s2 = axis.gravity ? gravity_counts_per_s2 : 0.0;
    config.inverted = scenario.drives.inverted.at(i);
    config.tick_in_step = in_step;
    config.absent = std::any_of(scenario.faults.begin(), scenario.faults.end(), [i](const Fault &fault) {
        return fault.kind == Fault_kind::node_missing && fault.axis == i;
    });
    return config;
}

Digitiser_config digitiser_config(const Scenario &scenario) {
    Digitiser_config config = scenario.digitiser;
    for (const Fault &fault : scenario.faults) {
        if (fault.kind == Fault_kind::packet_counter_start) {
            config.first_packet = static_cast<std::uint16_t>(fault.value);
        }
    }
    return config;
}

} // namespace

Apparatus::Apparatus(const Scenario &scenario, const std::filesystem::path &truth_path,
                     const Optics_factory &make_optics, Apparatus_outputs outputs, const Apparatus_clock &clock)
    : scenario_(scenario), start_ns_(clock.start_ns), outputs_(std::move(outputs)), scheduler_(clock.start_ns),
      bus_(scheduler_, clock.can_bits_per_s), kinematics_(scenario.instrument.axes),
      optics_(make_optics(scenario)), head_{scenario.instrument.head_diameter_mm, scenario.beam_diameter_at_head_mm,
                                            scenario.instrument.arm_radius_mm},
      detector_(scenario.seed, scenario.detector), shutter_(scheduler_),
      interlocks_([this](std::uint32_t line, bool level) { outputs_.line(line, level); },
                  [this](bool allowed) {
                      for (auto &drive : drives_) {
                          drive->set_sto(allowed);
                      }
                      shutter_.allow(interlocks_.light_allowed());
                  }),
      strobe_(scheduler_, scenario.seed, scenario.timing.strobe_latency_us, outputs_.strobe_edge,
              outputs_.strobe_level),
      digitiser_(
          scheduler_, digitiser_config(scenario),
          [this](std::uint64_t sample, std::int64_t time_ns) { return convert(sample, time_ns); },
          [this](bool rising) { strobe_.change(rising); }, [this] { outputs_.packet(); }),
      truth_(truth_path), sample_mounted_(scenario.sample_mounted) {
    for (std::size_t i = 0; i < axis_count; ++i) {
        drives_.at(i) = std::make_unique<Drive>(scheduler_, bus_, drive_config(scenario_, i, clock.drives_in_step));
    }
}

Apparatus::~Apparatus() = default;

void Apparatus::arm_faults() {
    faults_ =
        std::make_unique<Fault_injector>(scenario_.faults, Fault_targets{scheduler_, bus_, drives_, strobe_, digitiser_,
                                                                         interlocks_, outputs_.host_silent});
}

std::array<double, axis_count> Apparatus::position_deg(std::int64_t time_ns) const {
    std::array<double, axis_count> q_deg{};
    for (std::size_t i = 0; i < axis_count; ++i) {
        q_deg.at(i) = drives_.at(i)->true_position_counts(time_ns) / scenario_.instrument.axes.at(i).counts_per_deg;
    }
    return q_deg;
}

std::array<double, axis_count> Apparatus::speed_deg_per_s() const {
    std::array<double, axis_count> speed{};
    for (std::size_t i = 0; i < axis_count; ++i) {
        speed.at(i) = drives_.at(i)->true_velocity_counts_per_s() / scenario_.instrument.axes.at(i).counts_per_deg;
    }
    return speed;
}

bool Apparatus::at_rest() const {
    auto const speed = speed_deg_per_s();
    return std::all_of(speed.begin(), speed.end(), [](double v) { return std::abs(v) < rest_deg_per_s; });
}

bool Apparatus::line_level(std::uint32_t line) const {
    return line == GN_LINE_STROBE ? strobe_.level() : interlocks_.level(line);
}

bool Apparatus::sample_turning() const {
    for (std::size_t i = 0; i < axis_count; ++i) {
        const Axis_settings &axis = scenario_.instrument.axes.at(i);
        double const counts_per_s = drives_.at(i)->true_velocity_counts_per_s();
        if (axis.carries_sample && std::abs(counts_per_s) >= std::abs(axis.counts_per_deg) * rest_deg_per_s) {
            return true;
        }
    }
    return false;
}

double Apparatus::light_counts(std::int64_t time_ns, const std::array<double, axis_count> &q_deg) const {
    if (!lamp_on_ || !shutter_.was_open(time_ns)) {
        return 0.0;
    }
    Directions const d = kinematics_.directions(q_deg);
    double const dsf_per_sr =
        optics_->apparent_dsf_per_sr({d.incident, d.outgoing, sample_mounted_, d.lab_up, sample_turning()});
    double const lamp = detector_.lamp(seconds_on(time_ns));
    return scenario_.power_counts * lamp * dsf_per_sr * head_.transmitted(d.incident, d.outgoing);
}

gn_sample Apparatus::convert(std::uint64_t sample, std::int64_t time_ns) {
    if (scenario_.counter_pattern) {
        gn_sample counted{};
        counted.high_counts = static_cast<std::int32_t>(sample % counter_pattern_modulo);
        return counted;
    }
    std::int64_t const high_ns = time_ns - std::llround(1e3 * scenario_.high_delay_us);
    std::int64_t const low_ns = time_ns - std::llround(1e3 * scenario_.low_delay_us);
    double const high = light_counts(high_ns, position_deg(high_ns));
    double const low = low_ns == high_ns ? high : light_counts(low_ns, position_deg(low_ns));
    if (truth_.wanted()) {
        auto const q_deg = position_deg(time_ns);
        truth_.add({sample, time_ns, q_deg, low_ns == time_ns ? low : light_counts(time_ns, q_deg)});
    }
    double const time_s = seconds_on(time_ns);
    return detector_.convert(conversions_++, time_s, high, low, lamp_on_ ? detector_.lamp(time_s) : 0.0);
}

} // namespace gonio::sim
