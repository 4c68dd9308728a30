// photon_optics.hpp: the running twin's detector, read from stored photon maps: one per incident direction that the
// scan visits, traced when light first falls on the resting sample there, and one for the free beam.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <span>
#include <string>

#include "hit_map.hpp"
#include "optics.hpp"
#include "photon_scenario.hpp"

namespace gonio::sim {

struct Photon_optics_settings {
    double aperture_half_angle_rad = 0.0;
    double incident_tolerance_deg = 0.02;             // a stored map answers for poses this near
    std::size_t memory_bytes = std::size_t{1} << 30U; // of the maps; the one unused for longest goes first
};

// Traces one incident direction; `mounted` false: the free beam.
using Map_maker = std::function<Hit_map(const Incident &incident, bool mounted)>;

// A sample that turns is not traced at every pose on the way: the nearest stored map answers (dark if there is none),
// so that signal and gain stay what they are beside it. It is right to within the tolerance only at traced poses;
// account() says how many readings were answered so. Not thread-safe; the answers depend on the order of the poses
// alone.
class Photon_optics final : public Optics {
public:
    Photon_optics(Map_maker make_map, const Photon_optics_settings &settings);

    [[nodiscard]] double apparent_dsf_per_sr(const Reading &reading) const override;
    [[nodiscard]] std::int64_t held_ns() const override { return held_ns_; }
    [[nodiscard]] std::string account() const override;

    // Traces the free beam and these directions now, so that nobody waits for them later.
    void prepare(std::span<const Incident> incidents);

private:
    struct Kept {
        Incident incident;
        Hit_map map;
    };

    const Kept &kept_at(const Incident &incident) const;
    const Hit_map *sample_map(const Reading &reading) const;
    Hit_map timed(const Incident &incident, bool mounted) const;
    void forget() const;

    Map_maker make_map_;
    Photon_optics_settings settings_;
    // What has been traced is no state that a reader sees.
    mutable std::optional<Hit_map> free_beam_;
    mutable std::list<Kept> kept_; // the last used first
    mutable std::int64_t held_ns_ = 0;
    mutable std::uint64_t traced_ = 0;
    mutable std::uint64_t dropped_ = 0;
    mutable std::uint64_t while_turning_ = 0;
};

// The pose of the sample's axes that shows it so to the lab: theta may be negative, phi is the roll.
Incident incident_of(const Vec3 &incident, const Vec3 &lab_up);

} // namespace gonio::sim
