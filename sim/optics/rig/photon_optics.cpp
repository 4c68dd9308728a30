// photon_optics.cpp: which map answers, and when one is traced.
#include "photon_optics.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numbers>

namespace gonio::sim {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
// Encoders do not rest at whole degrees: poses are rounded to this, so that a map is that of the direction that was
// meant.
constexpr double grid_per_deg = 100.0;
constexpr double level =
    1e-6; // of the lab's +Y in the sample frame: higher and the axes are not those of CONVENTIONS.md

double on_grid(double angle_deg) {
    return std::round(angle_deg * grid_per_deg) / grid_per_deg + 0.0; // never -0
}

struct Pose {
    Vector incident;
    Vector up;
};

Pose pose_of(const Incident &incident) {
    double const theta = incident.theta_deg * deg;
    double const phi = incident.phi_deg * deg;
    return {{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)},
            {-std::sin(phi), std::cos(phi), 0.0}};
}

double apart_deg(const Pose &a, const Pose &b) {
    return std::max(length(a.incident - b.incident), length(a.up - b.up)) / deg;
}

} // namespace

Incident incident_of(const Vec3 &incident, const Vec3 &lab_up) {
    double phi = std::atan2(-lab_up[0], lab_up[1]);
    if (std::abs(lab_up[2]) > level) {
        phi = std::atan2(incident[1], incident[0]);
    }
    double const across = incident[0] * std::cos(phi) + incident[1] * std::sin(phi);
    return {std::atan2(across, incident[2]) / deg, phi < 0.0 ? phi / deg + 360.0 : phi / deg};
}

Photon_optics::Photon_optics(Map_maker make_map, const Photon_optics_settings &settings)
    : make_map_(std::move(make_map)), settings_(settings) {}

double Photon_optics::apparent_dsf_per_sr(const Reading &reading) const {
    Vector const outgoing = {reading.outgoing[0], reading.outgoing[1], reading.outgoing[2]};
    if (reading.sample_mounted) {
        const Hit_map *map = sample_map(reading);
        return map == nullptr ? 0.0 : map->fixed(outgoing, settings_.aperture_half_angle_rad).dsf_per_sr;
    }
    // The free beam was traced with the sample's axes at zero, where the sample frame is the lab's.
    if (!free_beam_) {
        free_beam_ = timed({0.0, 0.0}, false);
    }
    Vector const up = {reading.lab_up[0], reading.lab_up[1], reading.lab_up[2]};
    Vector const source = {reading.incident[0], reading.incident[1], reading.incident[2]};
    Vector const in_lab = Frame{cross(up, source), up, source}.to_local(outgoing);
    return free_beam_->fixed(in_lab, settings_.aperture_half_angle_rad).dsf_per_sr;
}

void Photon_optics::prepare(std::span<const Incident> incidents) {
    if (!free_beam_) {
        free_beam_ = timed({0.0, 0.0}, false);
    }
    for (const Incident &incident : incidents) {
        kept_at(incident);
    }
}

const Hit_map *Photon_optics::sample_map(const Reading &reading) const {
    Incident const incident = incident_of(reading.incident, reading.lab_up);
    if (!reading.sample_turning) {
        return &kept_at(incident).map;
    }
    ++while_turning_;
    Pose const pose = pose_of(incident);
    auto const nearest = std::min_element(kept_.begin(), kept_.end(), [&](const Kept &a, const Kept &b) {
        return apart_deg(pose_of(a.incident), pose) < apart_deg(pose_of(b.incident), pose);
    });
    return nearest == kept_.end() ? nullptr : &nearest->map;
}

const Photon_optics::Kept &Photon_optics::kept_at(const Incident &incident) const {
    Pose const pose = pose_of(incident);
    auto const found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept &kept) {
        return apart_deg(pose_of(kept.incident), pose) <= settings_.incident_tolerance_deg;
    });
    if (found != kept_.end()) {
        kept_.splice(kept_.begin(), kept_, found);
    } else {
        Incident const rounded = {on_grid(incident.theta_deg), on_grid(incident.phi_deg)};
        kept_.push_front({rounded, timed(rounded, true)});
        forget();
    }
    return kept_.front();
}

Hit_map Photon_optics::timed(const Incident &incident, bool mounted) const {
    auto const start = std::chrono::steady_clock::now();
    Hit_map map = make_map_(incident, mounted);
    ++traced_;
    held_ns_ += std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start).count();
    return map;
}

void Photon_optics::forget() const {
    std::size_t bytes = free_beam_ ? free_beam_->bytes() : 0;
    for (const Kept &kept : kept_) {
        bytes += kept.map.bytes();
    }
    while (bytes > settings_.memory_bytes && kept_.size() > 1) {
        bytes -= kept_.back().map.bytes();
        kept_.pop_back();
        ++dropped_;
    }
}

std::string Photon_optics::account() const {
    return "photon map: " + std::to_string(traced_) + " traced, " + std::to_string(dropped_) +
           " dropped for memory; while the sample turned, the nearest map answered " + std::to_string(while_turning_) +
           " readings";
}

} // namespace gonio::sim
