// virtual_goniophotometer.cpp: joins a scenario's sample, source and receiver for one incident direction.
#include "virtual_goniophotometer.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "batched_readings.hpp"
#include "elementary.hpp"

namespace gonio::sim {
namespace {

constexpr double turns_per_deg = 1.0 / 360.0;

// From here on, sorting hits and reading a map costs less than adding each hit to every aperture that holds it
// (measured).
constexpr double crowded_apertures_per_hit = 6.0;

// The lab's axes in the sample frame: the rows of lab <- sample = R_Y(-theta_i) R_z(-phi_i) (CONVENTIONS.md).
Frame lab_axes_of(const Incident &incident) {
    Sine_cosine const theta = sine_cosine_of_turns(incident.theta_deg * turns_per_deg);
    Sine_cosine const phi = sine_cosine_of_turns(incident.phi_deg * turns_per_deg);
    return {{theta.cosine * phi.cosine, theta.cosine * phi.sine, -theta.sine},
            {-phi.sine, phi.cosine, 0.0},
            {theta.sine * phi.cosine, theta.sine * phi.sine, theta.cosine}};
}

std::unique_ptr<Scene> scene_of(const Photon_scenario &scenario, const Sample_model &sample, const Frame &lab_axes,
                                Walk walk) {
    auto scene = make_scene(sample, walk);
    return scenario.surround ? scenario.surround(sample, std::move(scene), lab_axes) : std::move(scene);
}

} // namespace

Virtual_goniophotometer::Virtual_goniophotometer(const Photon_scenario &scenario, const Band &band,
                                                 const Incident &incident, bool mounted, Walk walk)
    : receiver_(scenario.receiver), trace_(scenario.trace), sample_(scenario.sample(band, mounted)),
      scene_(scene_of(scenario, sample_, lab_axes_of(incident), walk)), source_(scenario.source(band)),
      lab_axes_(lab_axes_of(incident)) {
    trace_.receiver_radius_mm = receiver_.radius_mm;
}

Virtual_goniophotometer::Sums Virtual_goniophotometer::read(std::span<const Vector> directions, double half_angle_rad,
                                                            const Photon_range &range, unsigned threads,
                                                            Watch &watch) const {
    auto const through = [&](auto &&sink) {
        Balance const balance = tracer().trace(range, threads, sink, watch);
        return Sums{sink.sums(), balance};
    };
    double const apertures_per_hit =
        static_cast<double>(directions.size()) * cap_sr(half_angle_rad) / cap_sr(std::numbers::pi);
    if (apertures_per_hit > crowded_apertures_per_hit) {
        return through(Batched_readings(directions, half_angle_rad, acceptance_half_angle_rad(), threads));
    }
    return through(Direction_index(directions, half_angle_rad, acceptance_half_angle_rad(), threads));
}

Virtual_goniophotometer::Stored Virtual_goniophotometer::store(const Photon_range &range, unsigned threads,
                                                               Watch &watch) const {
    Hit_store store(acceptance_half_angle_rad(), threads);
    Balance const balance = tracer().trace(range, threads, store, watch);
    return {Hit_map(store.release(), balance.photons, threads), balance};
}

double Virtual_goniophotometer::aperture_half_angle_rad() const {
    return arc_tangent(0.5 * receiver_.aperture_mm, receiver_.radius_mm);
}

double Virtual_goniophotometer::acceptance_half_angle_rad() const {
    return receiver_.acceptance_deg * turns_per_deg * 2.0 * std::numbers::pi;
}

Tracer Virtual_goniophotometer::tracer() const {
    return {*scene_, sample_.surfaces, *source_, lab_axes_, trace_};
}

} // namespace gonio::sim
