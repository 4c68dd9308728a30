// beam_source.hpp: the illuminator: a lamp's light through an aperture stop, collimated or focused on the sample.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "radial_draw.hpp"
#include "source.hpp"

namespace gonio::sim {

enum class Beam_kind {
    collimated, // diameter_mm is that of the stop; every place of the stop sends the lamp's profile
    focused,    // diameter_mm is that of the spot on the plane through O across the beam; every place of the spot
                // receives the lamp's profile
};

// A piece of the lamp: where it is seen from the middle of the stop (or from the spot), looking towards the source: x
// along the lab's X, y up. Lengths in the plane of the lamp, by their tangents.
struct Filament_bar {
    double x_deg = 0.0;
    double y_deg = 0.0;
    double width_deg = 0.0;  // along x; of a Gaussian bar: full width at half maximum
    double height_deg = 0.0; // along y
    double weight = 1.0;     // its power, relative to the other bars
    bool gaussian = false;   // false: uniform
};

struct Source_settings {
    Beam_kind kind = Beam_kind::collimated;
    double diameter_mm = 65.0;
    double diameter_edge_mm = 0.0;    // irradiance falls off at the rim: raised cosine, so wide, about the diameter
    double stop_distance_mm = 1500.0; // of the stop from O: where photons start
    // The lamp's angular profile (power per solid angle): one of the three, the last that is given.
    double opening_angle_deg = 0.5;   // full angle of a uniform disc; a focused beam's divergence
    double edge_deg = 0.0;            // its fall-off: raised cosine, so wide, about the opening angle
    std::vector<Radial_row> radial{}; // power per solid angle against the angle from the axis, from 0 on
    std::vector<Filament_bar> filament{};
    // Of the lamp from the stop, collimated only; 0: infinitely far. At a finite distance the beam diverges by the
    // stop's diameter as seen from the lamp; its irradiance on the stop is uniform.
    double lamp_distance_mm = 0.0;
    double stray_share = 0.0;           // of the power: leaves the stop in any direction within
    double stray_half_angle_deg = 10.0; // this angle from the axis, uniform in solid angle
    Stokes stokes{};                    // s is across the plane in which axis 1 turns the sample: along the lab's Y
};

// Light polarised linearly, `angle_deg` from s towards p (travel x s): 0 is s, 90 is p.
Stokes linear_polarisation(double angle_deg);

class Beam_source final : public Source {
public:
    // Throws Input_error on settings that make no beam.
    explicit Beam_source(const Source_settings &settings);
    [[nodiscard]] Start start(Photon_random &random) const override;

private:
    // Where in the lamp a photon comes from: tangents of the angles at which it is seen.
    struct Lamp_place {
        double x;
        double y;
    };
    struct Bar {
        Lamp_place middle;
        double width; // uniform: full; Gaussian: standard deviation
        double height;
        bool gaussian;
        double least; // cumulative share of the power before this bar, and
        double share; // its own
    };
    [[nodiscard]] Vector direction(double u, double v, double x_mm, double y_mm) const;
    [[nodiscard]] Lamp_place bar_place(double u, double v) const;

    bool focused_;
    double stop_distance_mm_;
    double lamp_nearness_per_mm_; // 1 / lamp distance
    double stray_share_;
    double stray_squared_chord_;
    Stokes stokes_;
    Radial_draw place_;
    std::optional<Radial_draw> angle_; // none: bars_
    std::vector<Bar> bars_;
};

} // namespace gonio::sim
