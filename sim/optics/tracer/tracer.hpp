// tracer.hpp: photons from the stop through the sample to the receiver sphere, with an exact account of their power.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "scene.hpp"
#include "source.hpp"
#include "surface.hpp"
#include "weight.hpp"

namespace gonio::sim {

// A photon on the receiver sphere, sample frame.
struct Receiver_hit {
    Vector place;         // unit, from the sphere's centre
    Vector direction;     // unit, of travel
    std::uint32_t weight; // whole_weight()
};

// Takes hits, many at a time. `worker` is below the number of threads; no two calls with the same worker overlap.
class Hit_sink {
public:
    virtual ~Hit_sink() = default;
    virtual void take(std::span<const Receiver_hit> hits, unsigned worker) = 0;
};

// Power in whole weights: emitted + roulette == stored + absorbed + lost, to the last bit.
struct Balance {
    std::uint64_t photons = 0;
    std::int64_t emitted = 0;
    std::int64_t stored = 0;       // reached the receiver sphere
    std::int64_t stored_front = 0; // of these, at z >= 0: the hemisphere of the sample's front
    std::int64_t absorbed = 0; // by surfaces, media and the room (what passes beside the receiver sphere); a material
                               // whose share is above 1 counts back
    std::int64_t lost = 0;     // gave up after most_interactions, or was no number: should be 0
    std::int64_t roulette = 0; // what survivors gained less what the dropped ones had: 0 on average

    // Sums of squares of the weights that arrived, by hemisphere: how sure these counts are.
    std::uint64_t front_square = 0;
    std::uint64_t back_square = 0;

    Balance &operator+=(const Balance &other);
};

struct Photon_range {
    std::uint64_t first = 0;
    std::uint64_t count = 0;
};

struct Trace_settings {
    std::uint64_t seed = 1;
    bool low_discrepancy = false;
    bool polarised = false;
    std::uint32_t most_interactions = 10000;
    double roulette_below = 0.05; // weight under which a photon survives with probability weight / this
    double receiver_radius_mm = 1020.0;
};

// Progress and cancellation, shared with whoever watches.
struct Watch {
    std::atomic<std::uint64_t> photons{0};
    std::atomic<bool> cancelled{false};
};

class Tracer {
public:
    // Keeps references. `lab_axes`: the lab's axes in the sample frame; its to_world() turns the source's vectors.
    Tracer(const Scene &scene, std::span<const Surface> surfaces, const Source &source, const Frame &lab_axes,
           const Trace_settings &settings);

    // Traces the photons of the range on `threads` threads. What photon n does depends on seed and n alone.
    // Cancelled: stops soon; the balance is that of the photons that were traced.
    Balance trace(const Photon_range &range, unsigned threads, Hit_sink &sink, Watch &watch) const;

private:
    const Scene &scene_;
    std::span<const Surface> surfaces_;
    const Source &source_;
    Frame lab_axes_;
    Trace_settings settings_;
};

} // namespace gonio::sim
