// closed_form.hpp: samples whose scattering is known in closed form: Lambertian, Gaussian lobes, the straight-through
// beam, any sum.
#pragma once

#include <memory>
#include <vector>

#include "optics.hpp"
#include "zonal.hpp"

namespace gonio::sim {

// DSF rho/pi |cos theta_s| on the incident side, tau/pi |cos theta_s| on the other.
struct Lambertian_part {
    double reflectance;
    double transmittance;
};

enum class Lobe_axis { mirror, retro, through };

// DSF A exp(-gamma^2 / (2 sigma^2)), gamma from the axis; A makes the integral over the sphere `integral`.
struct Gaussian_lobe {
    Lobe_axis about;
    double sigma_deg;
    double integral;
};

// A share of the beam that passes unchanged.
struct Straight_through {
    double transmittance;
};

struct Sample {
    std::vector<Lambertian_part> lambertian;
    std::vector<Gaussian_lobe> lobes;
    std::vector<Straight_through> straight;
};

// Peak of a Gaussian lobe of unit integral on the sphere [1/sr].
double gaussian_peak_per_sr(double sigma_rad);
// Integral over azimuth of max(0, cos) on the circle of radius beta about a direction at angle_rad from the normal.
double cosine_ring(double angle_rad, double beta_rad);

class Closed_form final : public Optics {
public:
    Closed_form(const Sample &sample, const Beam_profile &beam, double aperture_half_angle_rad);
    [[nodiscard]] double apparent_dsf_per_sr(const Reading &reading) const override;

private:
    struct Lobe {
        Lobe_axis about;
        double integral;
        Zonal_table log_dsf; // of unit integral
    };

    [[nodiscard]] double cosine(double angle_cosine) const;

    Beam_kernel kernel_;
    double reflectance_ = 0.0;
    double transmittance_ = 0.0;
    double straight_ = 0.0;
    double cosine_share_ = 0.0; // what the convolution leaves of a cosine, away from the horizon
    Zonal_table horizon_;       // the convolved cosine within the kernel's reach of the horizon
    std::vector<Lobe> lobes_;
};

} // namespace gonio::sim
