// world.cpp: joins the apparatus with the firmware's port.
#include "world.hpp"

#include <algorithm>
#include <cmath>

#include "out.h"

namespace gonio::sim {
namespace {

constexpr std::int64_t watch_every_ns = 1000000;
constexpr std::size_t log_lines_kept = 1000;

} // namespace

World::World(const Scenario &scenario, Carrier &carrier, const std::filesystem::path &truth_path,
             const Optics_factory &make_optics)
    : carrier_(carrier), apparatus_(scenario, truth_path, make_optics,
                                    {[this](std::uint32_t line, bool level) { port_->on_line(line, level); },
                                     [this](const gn_edge &edge) { port_->on_edge(edge); },
                                     {},
                                     [this] { port_->on_packet(); },
                                     [this] {
                                         carrier_.silence_host();
                                         host_lost();
                                     }}) {
    port_ = std::make_unique<Port_sim>(apparatus_.scheduler(), apparatus_.bus(), static_cast<Board &>(*this), carrier,
                                       scenario.timing, scenario.seed);
    apparatus_.arm_faults();
}

World::~World() = default;

void World::set_output(std::uint32_t output, bool on) {
    if (output == GN_OUT_SHUTTER) {
        apparatus_.set_shutter(on);
    } else if (output == GN_OUT_LAMP) {
        apparatus_.set_lamp(on);
    }
}

void World::operator_done(std::uint32_t action) {
    if (action == gonio_OperatorAction_OPERATOR_SAMPLE_MOUNTED) {
        apparatus_.mount_sample(true);
    } else if (action == gonio_OperatorAction_OPERATOR_SAMPLE_REMOVED) {
        apparatus_.mount_sample(false);
    }
}

void World::log(int level, const std::string &text) {
    if (log_lines_.size() < log_lines_kept) {
        log_lines_.push_back(std::to_string(static_cast<double>(scheduler().now_ns()) * 1e-9) + " <" +
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
        apparatus_.faults().path_began();
    }
}

void World::host_lost() {
    standstill_ = {};
    standstill_.watching = true;
    standstill_.since_ns = scheduler().now_ns();
    watch();
}

void World::watch() {
    auto const speed = apparatus_.speed_deg_per_s();
    double fastest = 0.0;
    for (double const v : speed) {
        fastest = std::max(fastest, std::abs(v));
    }
    if (!standstill_.reached && fastest < Apparatus::rest_deg_per_s) {
        standstill_.reached = true;
        standstill_.standstill_ns = scheduler().now_ns();
    }
    double &highest = standstill_.reached ? standstill_.max_speed_after_deg_per_s : standstill_.max_speed_deg_per_s;
    highest = std::max(highest, fastest);
    if (standstill_.dark_ns == 0 && dark()) {
        standstill_.dark_ns = scheduler().now_ns();
    }
    scheduler().after(watch_every_ns, [this] { watch(); });
}

} // namespace gonio::sim
