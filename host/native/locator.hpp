// locator.hpp: in which triangle a direction lies, and its weights of linear interpolation there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "parts.hpp"

namespace gonio::sphere {

struct Found {
    std::array<std::int64_t, 3> index{};
    std::array<double, 3> weight{};
    bool inside = false;
};

class Locator {
public:
    Locator(std::span<const Vec> unit, std::span<const double> reach, bool cut_at_horizon);

    [[nodiscard]] std::vector<Found> at(std::span<const Vec> directions) const;

private:
    struct Part {
        Part_of_sphere sphere;
        std::vector<double> reach;
        Index outwards = -1;                           // a triangle that looks outwards
        Vec axis;                                      // of the circle, where there is no hull
        std::vector<std::pair<double, Index>> azimuth; // about it, ascending
    };

    [[nodiscard]] const Part *part_of(const Vec &direction) const;
    static Found on_circle(const Part &part, const Vec &direction);
    static Found weights(const Part &part, Index triangle, const Vec &direction, const std::array<double, 3> &volume);
    static Found in_hull(const Part &part, const Vec &direction, Index &last);

    bool cut_at_horizon_;
    std::vector<Part> parts_;
};

} // namespace gonio::sphere
