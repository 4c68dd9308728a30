// stretches.hpp: where a cap meets the columns of a face's grid.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "place.hpp"

namespace gonio::sim {

// The stretches in which a cap meets the lines of constant u of a face. With the cap's parts (w, a, b) and cosine c:
// w + a u + b v >= c sqrt(1 + u^2 + v^2), a quadratic in v.
class Stretches {
public:
    // `generous`: answers too much rather than too little where the quadratic degenerates (the cap's edge touches the
    // face's horizon) or the cap is wider than a hemisphere.
    Stretches(const Face_cap &cap, bool generous)
        : cap_(cap), generous_(generous), steep_(cap.v * cap.v - cap.angle.cosine * cap.angle.cosine),
          solvable_(cap.angle.cosine > 0.0 && std::abs(steep_) > 1e-6) {}

    [[nodiscard]] Range at(double u) const {
        constexpr Range none{1.0, -1.0};
        if (!solvable_) {
            return generous_ ? Range{-1.0, 1.0} : none;
        }
        double const along = cap_.outward + cap_.u * u;
        double const inside = along * along + (1.0 + u * u) * steep_;
        double const root = cap_.angle.cosine * std::sqrt(std::max(inside, 0.0));
        double const middle = -along * cap_.v;
        if (steep_ < 0.0) {
            return inside < 0.0 || along < 0.0 ? none : Range{(middle + root) / steep_, (middle - root) / steep_};
        }
        // The cap holds the horizon's point on this line: all beyond one root.
        return cap_.v > 0.0 ? Range{(middle + root) / steep_, 1.0} : Range{-1.0, (middle - root) / steep_};
    }

private:
    Face_cap cap_;
    bool generous_;
    double steep_;
    bool solvable_;
};

// Numbers of the squares, `side` to a face, whose centres lie in the range.
struct Squares {
    Squares(const Range &range, double side)
        : first(number(std::ceil((range.low + 1.0) * 0.5 * side - 0.5), side)),
          last(std::max(first, number(std::floor((range.high + 1.0) * 0.5 * side + 0.5), side))) {}
    static std::size_t number(double place, double side) {
        return static_cast<std::size_t>(std::max(0.0, std::min(place, side)));
    }
    std::size_t first;
    std::size_t last; // one past
};

// No square of half this width reaches farther from its centre: asin x <= x (1 + 0.225 x^2) for x = sqrt(2) half_width
// up to 0.71; a whole face reaches acos(1 / sqrt(3)). The margin outweighs all rounding of the stretches.
inline double reach_rad(double half_width) {
    double const reach = std::numbers::sqrt2 * half_width * (1.0 + 0.45 * half_width * half_width);
    return std::min(reach, 0.95532) + 1e-9;
}

} // namespace gonio::sim
