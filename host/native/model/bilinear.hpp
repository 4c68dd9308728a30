// bilinear.hpp: values between the nodes of a square grid.
#pragma once

#include <algorithm>
#include <cstddef>

namespace gonio::model {

// At x along the rows and y across them, in cells from the first node; what lies outside is read at the rim. A place
// that is not a number is read at the first node.
template <typename Value>
[[gnu::always_inline]] inline double bilinear(const Value *nodes, std::ptrdiff_t size, double x, double y) {
    const auto cells = static_cast<double>(size - 1);
    x = x > 0.0 ? (x < cells ? x : cells) : 0.0;
    y = y > 0.0 ? (y < cells ? y : cells) : 0.0;
    const std::ptrdiff_t last = size - 2;
    const std::ptrdiff_t column = std::min(static_cast<std::ptrdiff_t>(x), last);
    const std::ptrdiff_t row = std::min(static_cast<std::ptrdiff_t>(y), last);
    x -= static_cast<double>(column);
    y -= static_cast<double>(row);
    const Value *const below = nodes + row * size + column;
    const Value *const above = below + size;
    const double left = static_cast<double>(below[0]);
    const double right = static_cast<double>(below[1]);
    const double upper_left = static_cast<double>(above[0]);
    const double upper_right = static_cast<double>(above[1]);
    const double lower = left + (right - left) * x;
    const double upper = upper_left + (upper_right - upper_left) * x;
    return lower + (upper - lower) * y;
}

} // namespace gonio::model
