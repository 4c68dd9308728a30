// world.cpp: joins devices, optics and the firmware's port.
#include "world.hpp"

#include <algorithm>
#include <cmath>

#include "edge.h"
#include "out.h"

namespace gonio::sim {
namespace {

constexpr std::uint32_t can_bits_per_s = 1000000;
constexpr double rest_deg_per_s = 1e-3; // an encoder count in 40 ms
constexpr std::int64_t watch_every_ns = 1000000;
constexpr std::size_t log_lines_kept = 1000;
constexpr double gravity_counts_per_s2 = -4.0e5; // of the free arm: downwards

// Nothing lies behind an axis's switch; the homing's index pulse is where the instrument file says.
Drive_config drive_config(const Scenario &scenario, std::size_t i) {
    const Axis_settings &axis = scenario.instrument.axes.at(i);
    Drive_config config;
    config.node = axis.node;
    config.name = axis.name;
    config.eds_directory = scenario.eds_directory;
    config.personality = scenario.drives.personality.at(i);
    config.counts_per_turn = axis.counts_per_turn;
    config.serial = static_cast<std::uint32_t>(1000 + i);
    config.initial_position_counts = scenario.drives.initial_deg.at(i) * axis.counts_per_deg;
    config.negative_switch_counts = axis.homing.switch_deg * axis.counts_per_deg;
    config.latch_delay_us = scenario.drives.latch_delay_us.at(i);
    config.brake = axis.brake;
    config.gravity_counts_per_s2 = axis.gravity ? gravity_counts_per_s2 : 0.0;
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

World::World(const Scenario &scenario, Carrier &carrier, const std::filesystem::path &truth_path,
             const Optics_factory &make_optics)
    : scenario_(scenario), bus_(scheduler_, can_bits_per_s), kinematics_(scenario.instrument.axes),
      optics_(make_optics(scenario)), head_{scenario.instrument.head_diameter_mm, scenario.beam_diameter_at_head_mm,
                                            scenario.instrument.arm_radius_mm},
      detector_(scenario.seed, scenario.detector), shutter_(scheduler_),
      interlocks_([this](std::uint32_t line, bool level) { port_->on_line(line, level); },
                  [this](bool allowed) {
                      for (auto &drive : drives_) {
                          drive->set_sto(allowed);
                      }
                      shutter_.allow(interlocks_.light_allowed());
                  }),
      strobe_(scheduler_, scenario.seed, scenario.timing.strobe_latency_us,
              [this](const gn_edge &edge) { port_->on_edge(edge); }),
      digitiser_(
          scheduler_, digitiser_config(scenario),
          [this](std::uint64_t sample, std::int64_t time_ns) { return convert(sample, time_ns); },
          [this](bool rising) { strobe_.change(rising); }, [this] { port_->on_packet(); }),
      truth_(truth_path), sample_mounted_(scenario.sample_mounted) {
    for (std::size_t i = 0; i < axis_count; ++i) {
        drives_.at(i) = std::make_unique<Drive>(scheduler_, bus_, drive_config(scenario_, i));
    }
    port_ = std::make_unique<Port_sim>(scheduler_, bus_, static_cast<Board &>(*this), carrier, scenario_.timing,
                                       scenario_.seed);
    faults_ = std::make_unique<Fault_injector>(
        scenario_.faults, Fault_targets{scheduler_, bus_, drives_, strobe_, digitiser_, interlocks_, [this, &carrier] {
                                            carrier.silence_host();
                                            host_lost();
                                        }});
}

World::~World() = default;

std::array<double, axis_count> World::position_deg(std::int64_t time_ns) const {
    std::array<double, axis_count> q_deg{};
    for (std::size_t i = 0; i < axis_count; ++i) {
        q_deg.at(i) = drives_.at(i)->true_position_counts(time_ns) / scenario_.instrument.axes.at(i).counts_per_deg;
    }
    return q_deg;
}

std::array<double, axis_count> World::speed_deg_per_s() const {
    std::array<double, axis_count> speed{};
    for (std::size_t i = 0; i < axis_count; ++i) {
        speed.at(i) = drives_.at(i)->true_velocity_counts_per_s() / scenario_.instrument.axes.at(i).counts_per_deg;
    }
    return speed;
}

bool World::at_rest() const {
    auto const speed = speed_deg_per_s();
    return std::all_of(speed.begin(), speed.end(), [](double v) { return std::abs(v) < rest_deg_per_s; });
}

bool World::sample_turning() const {
    for (std::size_t i = 0; i < axis_count; ++i) {
        const Axis_settings &axis = scenario_.instrument.axes.at(i);
        double const counts_per_s = drives_.at(i)->true_velocity_counts_per_s();
        if (axis.carries_sample && std::abs(counts_per_s) >= std::abs(axis.counts_per_deg) * rest_deg_per_s) {
            return true;
        }
    }
    return false;
}

double World::light_counts(std::int64_t time_ns, const std::array<double, axis_count> &q_deg) const {
    if (!lamp_on_ || !shutter_.was_open(time_ns)) {
        return 0.0;
    }
    Directions const d = kinematics_.directions(q_deg);
    double const dsf_per_sr =
        optics_->apparent_dsf_per_sr({d.incident, d.outgoing, sample_mounted_, d.lab_up, sample_turning()});
    double const lamp = detector_.lamp(1e-9 * static_cast<double>(time_ns));
    return scenario_.power_counts * lamp * dsf_per_sr * head_.transmitted(d.incident, d.outgoing);
}

gn_sample World::convert(std::uint64_t sample, std::int64_t time_ns) {
    std::int64_t const high_ns = time_ns - std::llround(1e3 * scenario_.high_delay_us);
    std::int64_t const low_ns = time_ns - std::llround(1e3 * scenario_.low_delay_us);
    double const high = light_counts(high_ns, position_deg(high_ns));
    double const low = low_ns == high_ns ? high : light_counts(low_ns, position_deg(low_ns));
    if (truth_.wanted()) {
        auto const q_deg = position_deg(time_ns);
        truth_.add({sample, time_ns, q_deg, low_ns == time_ns ? low : light_counts(time_ns, q_deg)});
    }
    double const time_s = 1e-9 * static_cast<double>(time_ns);
    return detector_.convert(conversions_++, time_s, high, low, lamp_on_ ? detector_.lamp(time_s) : 0.0);
}

void World::set_output(std::uint32_t output, bool on) {
    if (output == GN_OUT_SHUTTER) {
        shutter_.command(on);
    } else if (output == GN_OUT_LAMP) {
        lamp_on_ = on;
    }
}

void World::operator_done(std::uint32_t action) {
    if (action == gonio_OperatorAction_OPERATOR_SAMPLE_MOUNTED) {
        sample_mounted_ = true;
    } else if (action == gonio_OperatorAction_OPERATOR_SAMPLE_REMOVED) {
        sample_mounted_ = false;
    }
}

bool World::digitiser_start(std::uint32_t sample_period_us, std::uint32_t samples_per_strobe) {
    return digitiser_.start(sample_period_us, samples_per_strobe);
}

bool World::line_level(std::uint32_t line) const {
    return line == GN_LINE_STROBE ? strobe_.level() : interlocks_.level(line);
}

void World::log(int level, const std::string &text) {
    if (log_lines_.size() < log_lines_kept) {
        log_lines_.push_back(std::to_string(static_cast<double>(scheduler_.now_ns()) * 1e-9) + " <" +
                             std::to_string(level) + "> " + text);
    }
}

void World::told(const gonio_Event &event) {
    if (event.which_body == gonio_Event_status_tag) {
        last_status_ = event.body.status;
    } else if (event.which_body == gonio_Event_fault_tag) {
        last_fault_ = event.body.fault.sentence;
    } else if (event.which_body == gonio_Event_path_tag && event.body.path.end == gonio_PathEnd_PATH_RUNNING) {
        ++paths_;
        faults_->path_began();
    }
}

void World::host_lost() {
    standstill_ = {};
    standstill_.watching = true;
    standstill_.since_ns = scheduler_.now_ns();
    watch();
}

void World::watch() {
    auto const speed = speed_deg_per_s();
    double fastest = 0.0;
    for (double const v : speed) {
        fastest = std::max(fastest, std::abs(v));
    }
    if (!standstill_.reached && fastest < rest_deg_per_s) {
        standstill_.reached = true;
        standstill_.standstill_ns = scheduler_.now_ns();
    }
    double &highest = standstill_.reached ? standstill_.max_speed_after_deg_per_s : standstill_.max_speed_deg_per_s;
    highest = std::max(highest, fastest);
    if (standstill_.dark_ns == 0 && dark()) {
        standstill_.dark_ns = scheduler_.now_ns();
    }
    scheduler_.after(watch_every_ns, [this] { watch(); });
}

} // namespace gonio::sim
