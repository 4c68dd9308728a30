// photon_walk.hpp: one photon after another from the stop to the receiver sphere, and the account of their power: the
// state of one worker of the tracer.
#pragma once

#include <vector>

#include "elementary.hpp"
#include "low_discrepancy.hpp"
#include "polarisation.hpp"
#include "tracer.hpp"

namespace gonio::sim {

// What all workers of a run read.
struct Trace_scene {
    const Scene &scene;
    std::span<const Surface> surfaces;
    const Source &source;
    const Frame &lab_axes;
    const Trace_settings &settings;
};

// `polarised` false: no Stokes vector is turned.
template <bool polarised> class Photon_walk {
public:
    Photon_walk(const Trace_scene &run, Hit_sink &sink, unsigned worker)
        : run_(run), points_(run.settings.seed), sink_(sink), worker_(worker) {
        hits_.reserve(buffer_hits);
    }

    void trace(std::uint64_t photon) {
        Photon_random random(run_.settings.seed, photon);
        if (run_.settings.low_discrepancy) {
            random.give(points_.at(photon), Low_discrepancy::dimensions);
        }
        Start const start = run_.source.start(random);
        ray_ = {run_.lab_axes.to_world(start.position), run_.lab_axes.to_world(start.direction)};
        if constexpr (polarised) {
            stokes_ = start.stokes;
            s_axis_ = run_.lab_axes.to_world(start.reference);
        }
        absorption_per_mm_ = 0.0;
        weight_ = 1.0;
        whole_ = whole_weight(weight_);
        ++balance_.photons;
        balance_.emitted += whole_;
        for (std::uint32_t interactions = 0;; ++interactions) {
            Hit hit; // filled by closest()
            if (!run_.scene.closest(ray_, hit)) {
                leave();
                return;
            }
            if (interactions == run_.settings.most_interactions) {
                lose();
                return;
            }
            if (!cross_medium(hit.distance_mm) || !interact(hit, random) || !play_roulette(random)) {
                return;
            }
        }
    }

    // The hits that are still here go to the sink.
    void flush() {
        if (!hits_.empty()) {
            sink_.take(hits_, worker_);
            hits_.clear();
        }
    }
    [[nodiscard]] const Balance &balance() const { return balance_; }

private:
    static constexpr std::size_t buffer_hits = 512;

    void lose() { balance_.lost += whole_; }

    // Goes on with `weight`; false: nothing is left of the photon, or its weight is none.
    bool absorb(double weight) {
        if (!(weight >= 0.0 && weight <= most_weight)) {
            lose();
            return false;
        }
        std::uint32_t const left = whole_weight(weight);
        balance_.absorbed += static_cast<std::int64_t>(whole_) - left;
        weight_ = weight;
        whole_ = left;
        return left != 0;
    }

    // Beer and Lambert's law.
    bool cross_medium(double distance_mm) {
        return absorption_per_mm_ == 0.0 || absorb(weight_ * exponential(-absorption_per_mm_ * distance_mm));
    }

    bool interact(const Hit &hit, Photon_random &random) {
        Surface const &surface = run_.surfaces[hit.surface];
        Vector const towards = -ray_.direction;
        bool const from_front = dot(towards, hit.normal) >= 0.0;
        Vector const normal = from_front ? hit.normal : -hit.normal;
        Frame const local{hit.tangent, cross(normal, hit.tangent), normal};
        Arrival arrival{local.to_local(towards), from_front, {}};
        // A ray along the surface still comes from a side.
        arrival.towards.z = std::max(arrival.towards.z, 1e-12);
        if constexpr (polarised) {
            arrival.stokes = turned(stokes_, s_axis_, sim::s_axis(local, ray_.direction), ray_.direction);
        }
        Departure const departure = (from_front ? surface.front : surface.back)->scatter(arrival, random);
        if (!absorb(weight_ * departure.share)) {
            return false;
        }
        if (!(std::abs(dot(departure.direction, departure.direction) - 1.0) < 1e-6)) {
            lose();
            return false;
        }
        bool const to_front = from_front == (departure.direction.z >= 0.0);
        absorption_per_mm_ = to_front ? surface.front_absorption_per_mm : surface.back_absorption_per_mm;
        ray_ = {ray_.origin + hit.distance_mm * ray_.direction, local.to_world(departure.direction), hit.primitive};
        if constexpr (polarised) {
            stokes_ = departure.stokes;
            s_axis_ = sim::s_axis(local, ray_.direction);
        }
        return true;
    }

    // Faint photons survive with probability weight / roulette_below, and then weigh that.
    bool play_roulette(Photon_random &random) {
        double const limit = run_.settings.roulette_below;
        if (weight_ >= limit) {
            return true;
        }
        bool const survives = random.uniform() * limit < weight_;
        std::uint32_t const after = survives ? whole_weight(limit) : 0;
        balance_.roulette += static_cast<std::int64_t>(after) - whole_;
        weight_ = limit;
        whole_ = after;
        return survives;
    }

    // Nothing is in the way any more: on to the receiver sphere from within, or past it into the dark of the room.
    void leave() {
        double const radius_mm = run_.settings.receiver_radius_mm;
        double const b = dot(ray_.origin, ray_.direction);
        double const discriminant = b * b - (dot(ray_.origin, ray_.origin) - radius_mm * radius_mm);
        if (discriminant < 0.0) {
            absorb(0.0);
            return;
        }
        double const distance_mm = std::sqrt(discriminant) - b;
        if (distance_mm < 0.0) {
            absorb(0.0);
            return;
        }
        if (!(distance_mm >= 0.0)) { // no number
            lose();
            return;
        }
        if (!cross_medium(distance_mm)) {
            return;
        }
        Vector const place = ray_.origin + distance_mm * ray_.direction;
        balance_.stored += whole_;
        if (place.z >= 0.0) {
            balance_.stored_front += whole_;
            balance_.front_square += whole_square(whole_);
        } else {
            balance_.back_square += whole_square(whole_);
        }
        hits_.push_back({(1.0 / radius_mm) * place, ray_.direction, whole_});
        if (hits_.size() == buffer_hits) {
            flush();
        }
    }

    Trace_scene run_;
    Low_discrepancy points_;
    Hit_sink &sink_;
    unsigned worker_;
    std::vector<Receiver_hit> hits_;
    Balance balance_;

    // The photon under way.
    Ray ray_;
    double absorption_per_mm_ = 0.0; // of the medium that it is in
    double weight_ = 1.0;
    std::uint32_t whole_ = 0;
    Stokes stokes_; // relative to s_axis_
    Vector s_axis_;
};

} // namespace gonio::sim
