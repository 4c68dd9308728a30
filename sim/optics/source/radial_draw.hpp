// radial_draw.hpp: draws a number from a density that is given at nodes and linear between them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace gonio::sim {

class Radial_draw {
public:
    // Nodes ascend; at least two; some density is above zero. A single place (all nodes equal) is always drawn.
    Radial_draw(const std::vector<double> &nodes, const std::vector<double> &densities);
    // The inverse of the cumulative distribution at u in (0, 1): keeps the order of the numbers that it is given.
    [[nodiscard]] double draw(double u) const;

private:
    struct Segment {
        double begin;
        double width;
        double density; // at its begin
        double growth;  // of the density over the segment
        double before;  // integral up to its begin
        double scale;   // 1 / density of a uniform segment, 1 / width of another
    };
    std::vector<Segment> segments_;
    double integral_ = 0.0;
    std::vector<std::uint32_t> guide_; // segment in which each of its equal parts of (0, 1) begins
};

// A disc, or the directions within a cone: uniform out to `full_width` / 2 with a raised-cosine edge, `edge` wide,
// about it (closed_form/zonal.hpp has the same profile).
struct Soft_disc {
    double full_width;
    double edge;
};

// Density over the area of a disc: draws the square of the radius, in the square of the unit of `disc`.
Radial_draw squared_radius(const Soft_disc &disc);
// Of the unit sphere, between directions at an angle: 2 - 2 cos(angle).
double square_of_chord(double angle_deg);
// Density over solid angle of a cone, angles in degrees: draws the square of the chord.
Radial_draw squared_chord(const Soft_disc &cone_deg);

// Power per solid angle at an angle from the axis, linear between rows.
struct Radial_row {
    double angle_deg;
    double relative;
};
Radial_draw squared_chord(const std::vector<Radial_row> &rows);

} // namespace gonio::sim
