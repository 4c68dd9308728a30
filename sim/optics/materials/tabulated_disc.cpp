// tabulated_disc.cpp: maps of the disc of direction cosines that tabulated materials use.
#include <algorithm>
#include <cmath>

#include "elementary.hpp"
#include "tabulated.hpp"

namespace gonio::sim {

Disc_point disc_of_square(double u, double v) {
    double const a = 2.0 * u - 1.0;
    double const b = 2.0 * v - 1.0;
    if (a == 0.0 && b == 0.0) {
        return {0.0, 0.0};
    }
    // Turns: an eighth on each side of an axis.
    bool const wide = std::abs(a) > std::abs(b);
    double const radius = wide ? a : b;
    Sine_cosine const azimuth = sine_cosine_of_turns(wide ? 0.125 * (b / a) : 0.25 - 0.125 * (a / b));
    return {radius * azimuth.cosine, radius * azimuth.sine};
}

std::array<double, 2> square_of_disc(const Disc_point &point) {
    double const radius = std::sqrt(point.x * point.x + point.y * point.y);
    bool const wide = std::abs(point.x) > std::abs(point.y);
    double const longer = wide ? point.x : point.y;
    double const shorter = wide ? point.y : point.x;
    double const along = std::copysign(radius, longer);
    // Eighths of a turn from the axis, times the signed radius.
    double const across =
        along * arc_tangent(std::copysign(1.0, longer) * shorter, std::abs(longer)) * (4.0 / elementary::pi);
    double const a = wide ? along : across;
    double const b = wide ? across : along;
    return {std::clamp(0.5 * (a + 1.0), 0.0, 1.0), std::clamp(0.5 * (b + 1.0), 0.0, 1.0)};
}

Moved move_within_disc(const Disc_point &point, const Disc_point &from, const Disc_point &to) {
    double const dx = point.x - from.x;
    double const dy = point.y - from.y;
    double const radius = std::sqrt(dx * dx + dy * dy);
    if (radius == 0.0) {
        return {to, 1.0};
    }
    double const ux = dx / radius;
    double const uy = dy / radius;
    auto const to_rim = [&](const Disc_point &centre) {
        double const along = centre.x * ux + centre.y * uy;
        double const room = std::max(1.0 - centre.x * centre.x - centre.y * centre.y, 0.0);
        double const root = std::sqrt(along * along + room);
        return along > 0.0 ? room / (along + root) : root - along;
    };
    double const rim_from = to_rim(from);
    double const rim_to = to_rim(to);
    double const plain = 0.5 * std::min(rim_from, rim_to);
    double moved = radius;
    double slope = 1.0;
    if (radius > plain && rim_from > 0.0) {
        slope = (rim_to - plain) / (rim_from - plain);
        moved = plain + slope * (radius - plain);
    }
    return {{to.x + moved * ux, to.y + moved * uy}, slope * moved / radius};
}

} // namespace gonio::sim
