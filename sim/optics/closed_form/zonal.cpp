// zonal.cpp: quadrature, tables and convolution of zonal functions.
#include "zonal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace gonio::sim {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::size_t node_count = 24;

struct Rule {
    std::array<double, node_count> x;
    std::array<double, node_count> w;
};

// Gauss-Legendre nodes on [-1, 1] by Newton's method on P_n (Abramowitz and Stegun 25.4.29).
Rule gauss_legendre() {
    Rule rule{};
    for (std::size_t i = 0; i < node_count; ++i) {
        double x = std::cos(pi * (static_cast<double>(i) + 0.75) / (node_count + 0.5));
        double slope = 0.0;
        for (int iteration = 0; iteration < 20; ++iteration) {
            double p0 = 1.0;
            double p1 = x;
            for (std::size_t n = 2; n <= node_count; ++n) {
                double const k = static_cast<double>(n);
                double const p2 = ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = node_count * (x * p1 - p0) / (x * x - 1.0);
            x -= p1 / slope;
        }
        rule.x.at(i) = x;
        rule.w.at(i) = 2.0 / ((1.0 - x * x) * slope * slope);
    }
    return rule;
}

const Rule &rule() {
    static const Rule instance = gauss_legendre();
    return instance;
}

// Sorted, without repetitions, within [0, pi].
std::vector<double> tidy(std::vector<double> breaks) {
    for (double &b : breaks) {
        b = std::clamp(b, 0.0, pi);
    }
    std::sort(breaks.begin(), breaks.end());
    auto const close = [](double a, double b) { return b - a < 1e-12; };
    breaks.erase(std::unique(breaks.begin(), breaks.end(), close), breaks.end());
    return breaks;
}

} // namespace

double integrate_rad(const Zonal &f, const std::vector<double> &breaks_rad) {
    double sum = 0.0;
    for (std::size_t piece = 1; piece < breaks_rad.size(); ++piece) {
        double const middle = 0.5 * (breaks_rad[piece] + breaks_rad[piece - 1]);
        double const half = 0.5 * (breaks_rad[piece] - breaks_rad[piece - 1]);
        for (std::size_t i = 0; i < node_count; ++i) {
            // x = sin(u) makes a square root at either end smooth.
            double const u = 0.5 * pi * rule().x.at(i);
            sum += rule().w.at(i) * 0.5 * pi * std::cos(u) * half * f(middle + half * std::sin(u));
        }
    }
    return sum;
}

double integrate_sphere_sr(const Zonal &f, const std::vector<double> &breaks_rad) {
    return integrate_rad([&](double angle) { return 2.0 * pi * std::sin(angle) * f(angle); }, breaks_rad);
}

Zonal_table::Zonal_table(const Zonal &f, std::vector<double> breaks_rad, std::size_t steps_per_piece)
    : breaks_(tidy(std::move(breaks_rad))), steps_(steps_per_piece) {
    for (std::size_t piece = 1; piece < breaks_.size(); ++piece) {
        double const middle = 0.5 * (breaks_[piece] + breaks_[piece - 1]);
        double const half = 0.5 * (breaks_[piece] - breaks_[piece - 1]);
        for (std::size_t i = 0; i <= steps_; ++i) {
            double const u = pi * (static_cast<double>(i) / static_cast<double>(steps_) - 0.5);
            values_.push_back(f(middle + half * std::sin(u)));
        }
    }
}

double Zonal_table::at(double angle_rad) const {
    if (angle_rad >= breaks_.back()) {
        return 0.0;
    }
    auto const above = std::upper_bound(breaks_.begin() + 1, breaks_.end() - 1, angle_rad);
    auto const piece = static_cast<std::size_t>(above - breaks_.begin()) - 1;
    double const middle = 0.5 * (breaks_[piece + 1] + breaks_[piece]);
    double const half = 0.5 * (breaks_[piece + 1] - breaks_[piece]);
    double const x = std::clamp((angle_rad - middle) / half, -1.0, 1.0);
    double const position = (std::asin(x) / pi + 0.5) * static_cast<double>(steps_);
    auto const first =
        static_cast<std::size_t>(std::clamp(std::floor(position) - 1.0, 0.0, static_cast<double>(steps_ - 3)));
    double const t = position - static_cast<double>(first);
    const double *v = &values_[piece * (steps_ + 1) + first];
    // Lagrange's polynomial through four points at t = 0, 1, 2, 3.
    double const t1 = t - 1.0;
    double const t2 = t - 2.0;
    double const t3 = t - 3.0;
    return -v[0] * t1 * t2 * t3 / 6.0 + v[1] * t * t2 * t3 / 2.0 - v[2] * t * t1 * t3 / 2.0 + v[3] * t * t1 * t2 / 6.0;
}

double Beam_profile::at(double angle_rad) const {
    double const radius = 0.5 * full_width_rad;
    if (angle_rad <= radius - 0.5 * edge_rad) {
        return 1.0;
    }
    if (angle_rad >= radius + 0.5 * edge_rad) {
        return 0.0;
    }
    return 0.5 * (1.0 - std::sin(pi * (angle_rad - radius) / edge_rad));
}

std::vector<double> Beam_profile::breaks_rad() const {
    double const radius = 0.5 * full_width_rad;
    return tidy({0.0, radius - 0.5 * edge_rad, radius + 0.5 * edge_rad});
}

Beam_kernel::Beam_kernel(const Beam_profile &beam, double aperture_half_angle_rad) {
    double const alpha = aperture_half_angle_rad;
    std::vector<double> const beam_breaks = beam.breaks_rad();
    breaks_ = {0.0};
    for (double const edge : {beam_breaks[1], beam_breaks.back()}) {
        breaks_.push_back(std::abs(edge - alpha));
        breaks_.push_back(edge + alpha);
    }
    breaks_ = tidy(breaks_);
    double const scale = 1.0 / (integrate_sphere_sr([&](double b) { return beam.at(b); }, beam_breaks) * 2.0 * pi *
                                (1.0 - std::cos(alpha)));
    auto const exact = [&](double gamma) {
        // The part of the circle of radius beta about the beam's centre that lies within the aperture.
        auto const within = [&](double beta) {
            double const product = std::sin(gamma) * std::sin(beta);
            double const level = std::cos(alpha) - std::cos(gamma) * std::cos(beta);
            if (product <= 0.0 || std::abs(level) >= product) {
                return level < 0.0 || (product <= 0.0 && level <= 0.0) ? 2.0 * pi : 0.0;
            }
            return 2.0 * std::acos(level / product);
        };
        double const end = beam_breaks.back();
        std::vector<double> pieces = beam_breaks;
        pieces.push_back(std::min(end, std::abs(gamma - alpha)));
        pieces.push_back(std::min(end, gamma + alpha));
        return scale * integrate_rad([&](double b) { return beam.at(b) * std::sin(b) * within(b); }, tidy(pieces));
    };
    table_ = Zonal_table(exact, breaks_, 160);
}

double Beam_kernel::convolve(const std::function<double(double, double)> &ring, double angle_rad) const {
    auto const shell = [&](double beta) { return per_sr(beta) * std::sin(beta) * ring(angle_rad, beta); };
    return integrate_rad(shell, breaks_);
}

} // namespace gonio::sim
