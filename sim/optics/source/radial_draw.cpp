// radial_draw.cpp: cumulative sums, their inverse, and the profiles of discs and cones.
#include "radial_draw.hpp"

#include <algorithm>
#include <cmath>

#include "elementary.hpp"

namespace gonio::sim {
namespace {

constexpr std::size_t guide_parts = 512;
constexpr std::size_t edge_steps = 256;   // chords of the raised cosine: its density to 2e-5 of the middle
constexpr std::size_t steps_per_row = 64; // rows are linear in the angle, the draw in its square
constexpr double rad_per_deg = elementary::pi / 180.0;

double raised_cosine(double x) {
    return 0.5 * (1.0 + sine_cosine_of_turns(0.5 * x).cosine);
}

// The radii of a soft disc and what they have.
template <typename Square> Radial_draw soft(const Soft_disc &disc, const Square &square) {
    double const inner = 0.5 * (disc.full_width - disc.edge);
    std::vector<double> nodes = {0.0, square(inner)};
    std::vector<double> densities = {1.0, 1.0};
    if (disc.edge > 0.0) {
        for (std::size_t i = 1; i <= edge_steps; ++i) {
            double const part = static_cast<double>(i) / edge_steps;
            nodes.push_back(square(inner + disc.edge * part));
            densities.push_back(raised_cosine(part));
        }
    }
    return {nodes, densities};
}

} // namespace

double square_of_chord(double angle_deg) {
    double const half_chord = sine_cosine(0.5 * rad_per_deg * angle_deg).sine;
    return 4.0 * half_chord * half_chord;
}

Radial_draw::Radial_draw(const std::vector<double> &nodes, const std::vector<double> &densities) : guide_(guide_parts) {
    for (std::size_t i = 1; i < nodes.size(); ++i) {
        double const width = nodes[i] - nodes[i - 1];
        double const density = densities[i - 1];
        double const growth = densities[i] - density;
        double const divisor = growth == 0.0 ? density : width;
        segments_.push_back({nodes[i - 1], width, density, growth, integral_, divisor > 0.0 ? 1.0 / divisor : 0.0});
        integral_ += (density + 0.5 * growth) * width;
    }
    std::uint32_t segment = 0;
    for (std::size_t part = 0; part < guide_parts; ++part) {
        double const begin = integral_ * (static_cast<double>(part) / guide_parts);
        while (segment + 1 < segments_.size() && segments_[segment + 1].before <= begin) {
            ++segment;
        }
        guide_[part] = segment;
    }
}

double Radial_draw::draw(double u) const {
    double const target = u * integral_;
    const Segment *segment = &segments_[guide_[static_cast<std::size_t>(u * guide_parts)]];
    const Segment *const last = &segments_.back();
    while (segment != last && segment[1].before < target) {
        ++segment;
    }
    double const rest = (target - segment->before) * segment->scale;
    if (segment->growth == 0.0) {
        return segment->begin + std::min(rest, segment->width);
    }
    // The density grows from a by b over the segment: a t + b t^2 / 2 = rest, solved without cancellation.
    double const a = segment->density;
    double const root = a + std::sqrt(std::max(a * a + 2.0 * segment->growth * rest, 0.0));
    return segment->begin + segment->width * std::min(root > 0.0 ? 2.0 * rest / root : 0.0, 1.0);
}

Radial_draw squared_radius(const Soft_disc &disc) {
    return soft(disc, [](double radius) { return radius * radius; });
}

Radial_draw squared_chord(const Soft_disc &cone_deg) {
    return soft(cone_deg, square_of_chord);
}

Radial_draw squared_chord(const std::vector<Radial_row> &rows) {
    std::vector<double> nodes;
    std::vector<double> densities;
    for (std::size_t row = 1; row < rows.size(); ++row) {
        for (std::size_t step = row == 1 ? 0 : 1; step <= steps_per_row; ++step) {
            double const part = static_cast<double>(step) / steps_per_row;
            nodes.push_back(square_of_chord(rows[row - 1].angle_deg * (1.0 - part) + rows[row].angle_deg * part));
            densities.push_back(rows[row - 1].relative * (1.0 - part) + rows[row].relative * part);
        }
    }
    return {nodes, densities};
}

} // namespace gonio::sim
