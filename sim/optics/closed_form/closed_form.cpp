// closed_form.cpp: the closed forms, convolved once with beam and aperture into tables and looked up per reading.
#include "closed_form.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gonio::sim {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double lobe_reach_sigma = 8.0; // exp(-32): under every detector's floor

double angle_between_rad(const Vec3 &u, const Vec3 &v) {
    double const dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    if (dot < 0.7) {
        return std::acos(std::max(dot, -1.0));
    }
    double const dx = u[0] - v[0];
    double const dy = u[1] - v[1];
    double const dz = u[2] - v[2];
    return 2.0 * std::asin(0.5 * std::sqrt(dx * dx + dy * dy + dz * dz));
}

Vec3 axis_of(Lobe_axis about, const Vec3 &incident) {
    switch (about) {
    case Lobe_axis::mirror:
        return {-incident[0], -incident[1], incident[2]};
    case Lobe_axis::retro:
        return incident;
    case Lobe_axis::through:
        break;
    }
    return {-incident[0], -incident[1], -incident[2]};
}

// Breaks so close together that a table of a lobe of this sigma is smooth in each piece.
std::vector<double> even_breaks(double end_rad, double piece_rad) {
    auto const pieces = static_cast<std::size_t>(std::ceil(end_rad / piece_rad));
    std::vector<double> breaks;
    for (std::size_t i = 0; i <= pieces; ++i) {
        breaks.push_back(end_rad * static_cast<double>(i) / static_cast<double>(pieces));
    }
    return breaks;
}

Zonal_table log_of_convolved_lobe(const Beam_kernel &kernel, double sigma_rad) {
    double const peak = gaussian_peak_per_sr(sigma_rad);
    auto const ring = [&](double angle, double beta) {
        double const product = std::sin(angle) * std::sin(beta);
        double const near = std::sin(0.5 * (angle - beta));
        // Trapezoid over a period: converges at once when it resolves the lobe's width on the circle.
        int const half_steps = 12 + static_cast<int>(6.0 * std::sqrt(product) / sigma_rad);
        double sum = 0.0;
        for (int i = 0; i <= half_steps; ++i) {
            double const half_turn = std::sin(0.5 * pi * i / half_steps);
            double const haversine = near * near + product * half_turn * half_turn;
            double const gamma = 2.0 * std::asin(std::sqrt(std::min(haversine, 1.0)));
            double const value = std::exp(-0.5 * gamma * gamma / (sigma_rad * sigma_rad));
            sum += i == 0 || i == half_steps ? 0.5 * value : value;
        }
        return 2.0 * pi * sum / half_steps;
    };
    double const end = std::min(pi, lobe_reach_sigma * sigma_rad + kernel.end_rad());
    return {[&](double angle) { return std::log(peak * kernel.convolve(ring, angle)); },
            even_breaks(end, 2.0 * sigma_rad), 36};
}

} // namespace

double gaussian_peak_per_sr(double sigma_rad) {
    double const end = std::min(pi, 12.0 * sigma_rad);
    auto const lobe = [&](double gamma) { return std::exp(-0.5 * gamma * gamma / (sigma_rad * sigma_rad)); };
    return 1.0 / integrate_sphere_sr(lobe, even_breaks(end, sigma_rad));
}

double cosine_ring(double angle_rad, double beta_rad) {
    double const mean = std::cos(angle_rad) * std::cos(beta_rad);
    double const swing = std::sin(angle_rad) * std::sin(beta_rad);
    if (mean >= swing) {
        return 2.0 * pi * mean;
    }
    if (mean <= -swing) {
        return 0.0;
    }
    double const half_arc = std::acos(-mean / swing);
    return 2.0 * (mean * half_arc + swing * std::sin(half_arc));
}

Closed_form::Closed_form(const Sample &sample, const Beam_profile &beam, double aperture_half_angle_rad)
    : kernel_(beam, aperture_half_angle_rad) {
    for (const Lambertian_part &part : sample.lambertian) {
        reflectance_ += part.reflectance;
        transmittance_ += part.transmittance;
    }
    for (const Straight_through &part : sample.straight) {
        straight_ += part.transmittance;
    }
    for (const Gaussian_lobe &part : sample.lobes) {
        lobes_.push_back({part.about, part.integral, log_of_convolved_lobe(kernel_, part.sigma_deg * pi / 180.0)});
    }
    cosine_share_ = kernel_.convolve(cosine_ring, 0.0);
    std::vector<double> breaks = {0.5 * pi};
    for (double const edge : kernel_.breaks_rad()) {
        breaks.push_back(0.5 * pi - edge);
        breaks.push_back(0.5 * pi + edge);
    }
    horizon_ = Zonal_table([this](double angle) { return kernel_.convolve(cosine_ring, angle); }, breaks, 48);
}

double Closed_form::cosine(double angle_cosine) const {
    double const angle = std::acos(std::clamp(angle_cosine, -1.0, 1.0));
    return angle < horizon_.begin_rad() ? cosine_share_ * angle_cosine : horizon_.at(angle);
}

double Closed_form::apparent_dsf_per_sr(const Reading &reading) const {
    Vec3 const through = axis_of(Lobe_axis::through, reading.incident);
    if (!reading.sample_mounted) {
        return kernel_.per_sr(angle_between_rad(through, reading.outgoing));
    }
    double const side = reading.incident[2] >= 0.0 ? 1.0 : -1.0;
    double const height = side * reading.outgoing[2];
    double dsf = 0.0;
    if (reflectance_ > 0.0) {
        dsf += reflectance_ / pi * cosine(height);
    }
    if (transmittance_ > 0.0) {
        dsf += transmittance_ / pi * cosine(-height);
    }
    for (const Lobe &lobe : lobes_) {
        double const gamma = angle_between_rad(axis_of(lobe.about, reading.incident), reading.outgoing);
        if (gamma < lobe.log_dsf.end_rad()) {
            dsf += lobe.integral * std::exp(lobe.log_dsf.at(gamma));
        }
    }
    if (straight_ > 0.0) {
        dsf += straight_ * kernel_.per_sr(angle_between_rad(through, reading.outgoing));
    }
    return dsf;
}

} // namespace gonio::sim
