// sorted_cells.cpp: counting sort.
#include "sorted_cells.hpp"

#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace gonio::model {
namespace {

std::size_t cell_of(double disc, double half, double last) {
    const double at = (disc + 1.0) * half;
    return static_cast<std::size_t>(at > 0.0 ? (at < last ? at : last) : 0.0);
}

} // namespace

Sorted_cells sorted_cells(std::span<const Vec> unit, std::size_t size) {
    constexpr std::size_t WIDEST = 4096;
    if (size < 1 || size > WIDEST) {
        throw std::invalid_argument("a grid of cells has 1 to 4096 along a side");
    }
    const double half = 0.5 * static_cast<double>(size);
    const auto last = static_cast<double>(size - 1);
    std::vector<std::uint32_t> key(unit.size());
    std::vector<std::int64_t> next(size * size + 1, 0);
    for (std::size_t i = 0; i < unit.size(); ++i) {
        const double scale = 1.0 / std::sqrt(1.0 + unit[i].z);
        const std::size_t cell = cell_of(unit[i].y * scale, half, last) * size + cell_of(unit[i].x * scale, half, last);
        key[i] = static_cast<std::uint32_t>(cell);
        ++next[cell + 1];
    }
    Sorted_cells sorted;
    sorted.start.push_back(0);
    for (std::size_t cell = 0; cell < size * size; ++cell) {
        if (next[cell + 1] > 0) {
            sorted.home.push_back(static_cast<std::int64_t>(cell));
            sorted.start.push_back(next[cell] + next[cell + 1]);
        }
        next[cell + 1] += next[cell];
    }
    sorted.order.resize(unit.size());
    for (std::size_t i = 0; i < unit.size(); ++i) {
        sorted.order[static_cast<std::size_t>(next[key[i]]++)] = static_cast<std::int64_t>(i);
    }
    return sorted;
}

} // namespace gonio::model
