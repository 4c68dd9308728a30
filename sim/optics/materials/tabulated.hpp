// tabulated.hpp: a material from data: a BSDF that was measured or computed, as a table to draw from.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "material.hpp"

namespace gonio::sim {

// BSDF for a few incident directions on each side. Outgoing: `cells` x `cells` squares per hemisphere in the
// Shirley-Chiu map of the direction cosines (x, y): cells of equal projected solid angle pi / cells^2. Directions are
// in the frame of the light's arrival (material.hpp): z is the normal on the side that it comes from, x the tangent on
// both sides, so that y turns over on the back.
struct Scatter_table {
    // Mirror and through have the same direction cosines, and move both hemispheres with them; retro moves what is
    // reflected with the incident direction and what is transmitted with the straight-through one.
    enum class Follow { none, mirror, retro, through };
    struct Distribution {
        double theta_deg; // of the incident direction, 0 to 90 from the side's normal
        double phi_deg;
        std::vector<double> reflected;   // BSDF [1/sr] per cell, row by row (y, then x); empty: none
        std::vector<double> transmitted; // the same, seen in (x, y) of the same frame
    };
    std::uint32_t cells = 64;
    // Between incident directions the distribution is shifted in direction cosines with this direction: a peak moves.
    Follow follow = Follow::none;
    bool isotropic = true; // only theta counts; the table is turned to the photon's azimuth
    // Isotropic: a theta each. Else rings of equal theta, each with phi all round (one phi: the same all round).
    std::vector<Distribution> front;
    std::vector<Distribution> back; // empty: as the front
};

// The map between the unit square (u along x, v along y) and the unit disc of direction cosines (Shirley and Chiu
// 1997).
struct Disc_point {
    double x;
    double y;
};
Disc_point disc_of_square(double u, double v);
std::array<double, 2> square_of_disc(const Disc_point &point); // {u, v}

// Carries the disc onto itself so that `from` comes to `to`: a plain shift near it, squeezed or stretched along the
// radii further out, so that nothing leaves the disc. Exchanging from and to undoes it. Adds the factor on areas there.
struct Moved {
    Disc_point point;
    double area;
};
Moved move_within_disc(const Disc_point &point, const Disc_point &from, const Disc_point &to);

// Between the incident directions of the table: linear in theta, and in phi along a ring; beyond the first or last
// theta the nearest one serves. A neighbour is chosen at random, moved as the table says, and one of its cells is
// drawn. The share is the directional-hemispherical sum, interpolated alike: it does not depend on the draw.
class Tabulated final : public Material {
public:
    // `name` for messages. Throws Input_error where the table is incomplete, negative, or sends out more than it gets.
    Tabulated(const Scatter_table &table, const std::string &name);
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override;
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override;
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override;

private:
    static constexpr std::size_t guides = 1024;
    struct Incident_cells {
        double theta_rad;
        double phi_rad;
        Disc_point incident;
        Disc_point azimuth; // unit
        double reflectance;
        double transmittance;
        std::vector<double> reflected;
        std::vector<double> transmitted;
        std::vector<double> sums;                    // of both, cell by cell, reflected first: to draw from
        std::array<std::uint32_t, guides + 1> guide; // first cell beyond each even part of the sum: where to search
        std::size_t last_cell;                       // that is not dark
        // The cell in which the sum passes this value.
        [[nodiscard]] std::size_t cell_at(double sum) const;
    };
    // By theta, of equal theta by phi.
    using Ring = std::vector<Incident_cells>;
    struct Neighbour {
        const Incident_cells *cells;
        double weight;
    };
    struct Neighbours {
        std::array<Neighbour, 4> of;
        std::size_t count = 0;
    };

    [[nodiscard]] std::vector<Ring> rings(const std::vector<Scatter_table::Distribution> &distributions,
                                          const std::string &name, const std::string &side) const;
    [[nodiscard]] Incident_cells incident_cells(const Scatter_table::Distribution &distribution,
                                                const std::string &name) const;
    [[nodiscard]] Neighbours neighbours(const Arrival &arrival) const;
    static void add_ring(const Ring &ring, double phi_rad, double weight, Neighbours &found);
    // From the neighbour's disc to the photon's: a turn (cosine, sine), then a move.
    struct Passage {
        Disc_point turn;
        Disc_point from;
        Disc_point to;
    };
    [[nodiscard]] Passage passage(const Incident_cells &cells, const Vector &towards, bool reflected) const;

    std::uint32_t cells_;
    Scatter_table::Follow follow_;
    bool isotropic_;
    std::vector<Ring> front_;
    std::vector<Ring> back_;
};

// Reads a table from a text file; throws Input_error. Lines of words, # starts a comment:
//     gonio-scatter-table 1
//     cells 64
//     follow mirror                # or none, retro, through
//     isotropic yes                # or no
//     front 30 0 reflected         # side (front, back), theta and phi in degrees, reflected or transmitted; then
//     0.31 0.33 ...                # `cells` lines of `cells` numbers: BSDF in 1/sr, v (along y) by line, u along x
//     front 30 0 transmitted
//     ...
Scatter_table load_scatter_table(const std::filesystem::path &path);

} // namespace gonio::sim
