// zonal.hpp: functions of the angle to an axis: their tables, and their convolution on the sphere with beam and
// aperture.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace gonio::sim {

using Zonal = std::function<double(double angle_rad)>;

// Integral of f over [breaks.front(), breaks.back()], piece by piece; f may have square-root kinks at the breaks.
double integrate_rad(const Zonal &f, const std::vector<double> &breaks_rad);
// Integral over the sphere of a zonal function that is zero beyond the last break [sr].
double integrate_sphere_sr(const Zonal &f, const std::vector<double> &breaks_rad);

// A zonal function, tabulated piece by piece between its kinks (points crowd there) with cubic interpolation; 0 beyond
// the end.
class Zonal_table {
public:
    Zonal_table() = default;
    Zonal_table(const Zonal &f, std::vector<double> breaks_rad, std::size_t steps_per_piece);
    [[nodiscard]] double at(double angle_rad) const;
    [[nodiscard]] double begin_rad() const { return breaks_.front(); }
    [[nodiscard]] double end_rad() const { return breaks_.back(); }

private:
    std::vector<double> breaks_;
    std::vector<double> values_; // steps_ + 1 for each piece
    std::size_t steps_ = 0;
};

// The beam seen from the sample's centre: a top hat with a raised-cosine edge (the transition is edge_rad wide).
struct Beam_profile {
    double full_width_rad;
    double edge_rad;

    // Not normalised: 1 in the middle.
    [[nodiscard]] double at(double angle_rad) const;
    [[nodiscard]] std::vector<double> breaks_rad() const;
};

// Beam and aperture together: the beam's profile averaged over the aperture's disc, with unit integral [1/sr].
class Beam_kernel {
public:
    Beam_kernel(const Beam_profile &beam, double aperture_half_angle_rad);
    [[nodiscard]] double per_sr(double angle_rad) const { return table_.at(angle_rad); }
    [[nodiscard]] double end_rad() const { return breaks_.back(); }
    [[nodiscard]] const std::vector<double> &breaks_rad() const { return breaks_; }
    // Convolution at `angle_rad` of the function whose integral over azimuth on a circle of radius beta about that
    // angle is `ring(angle, beta)`.
    [[nodiscard]] double convolve(const std::function<double(double angle_rad, double beta_rad)> &ring,
                                  double angle_rad) const;

private:
    std::vector<double> breaks_;
    Zonal_table table_;
};

} // namespace gonio::sim
