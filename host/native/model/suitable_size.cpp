// suitable_size.cpp: points are counted in bins; the bin that half of the points have no fewer neighbours in tells.
#include "suitable_size.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gonio::model {
namespace {

constexpr double POINTS_PER_BIN = 16.0;
constexpr double MOST_BINS = 64.0;

bool inside(const Place &at, double half_width) {
    return std::fabs(at[0]) <= half_width && std::fabs(at[1]) <= half_width;
}

} // namespace

std::size_t suitable_size(std::span<const Place> position, double half_width, std::size_t most_cells) {
    const auto n = static_cast<std::size_t>(
        std::count_if(position.begin(), position.end(), [&](const Place &at) { return inside(at, half_width); }));
    if (n == 0) {
        return 2;
    }
    const double side = std::floor(std::clamp(std::sqrt(static_cast<double>(n) / POINTS_PER_BIN), 1.0, MOST_BINS));
    const auto bins = static_cast<std::size_t>(side);
    std::vector<std::size_t> number(bins * bins, 0);
    for (const Place &at : position) {
        if (inside(at, half_width)) {
            const auto column = static_cast<std::size_t>((at[0] / half_width + 1.0) * (0.5 * side));
            const auto row = static_cast<std::size_t>((at[1] / half_width + 1.0) * (0.5 * side));
            ++number[std::min(row, bins - 1) * bins + std::min(column, bins - 1)];
        }
    }
    std::sort(number.begin(), number.end());
    std::size_t counted = 0;
    std::size_t usual = 0;
    for (std::size_t bin = 0; 2 * counted < n; ++bin) {
        usual = number[bin];
        counted += usual;
    }
    const double cells = side * std::sqrt(static_cast<double>(usual));
    const double power = std::clamp(std::nearbyint(std::log2(cells)), 0.0, std::log2(static_cast<double>(most_cells)));
    return (std::size_t{1} << static_cast<std::size_t>(power)) + 1;
}

} // namespace gonio::model
