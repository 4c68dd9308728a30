// sorted_cells.cpp: counting sort, every pass over the points in the order in which they lie in memory.
#include "sorted_cells.hpp"

#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace gonio::model {
namespace {

constexpr std::size_t WIDEST = 4096;
constexpr double CALM = 0.8;  // of the mean: at the edge of a top hat it is 1
constexpr double NOISE = 2.0; // times the points' mean variance: what noise makes of a few

struct Cell {
    std::uint32_t points = 0;
    std::uint32_t every = 1; // n-th stays
    double weight = 0.0;
    double value = 0.0; // these times the weight
    double square = 0.0;
    double variance = 0.0;
    std::array<double, 6> sum{}; // of those that stay

    void add(double w, double v, double noise) {
        ++points;
        weight += w;
        value += w * v;
        square += w * v * v;
        variance += w * noise;
    }

    void thin(std::size_t most) {
        const double mean2 = value * value / weight;
        const bool calm = square - mean2 <= CALM * CALM * mean2 + NOISE * variance;
        every = points > most && calm ? static_cast<std::uint32_t>((points + most - 1) / most) : 1;
        points = 0;
    }
};

std::size_t cell_of(double disc, double half, double last) {
    const double at = (disc + 1.0) * half;
    return static_cast<std::size_t>(at > 0.0 ? (at < last ? at : last) : 0.0);
}

void check(const Measured &points, std::size_t size, std::size_t most) {
    const std::size_t n = points.unit.size();
    if (points.value.size() != n || points.variance.size() != n || points.weight.size() != n) {
        throw std::invalid_argument("one value, variance and weight per point is needed");
    }
    if (size < 1 || size > WIDEST || most < 1) {
        throw std::invalid_argument("a grid of cells has 1 to 4096 along a side, and each holds a point");
    }
}

} // namespace

Sorted_cells sorted_cells(const Measured &points, std::size_t size, std::size_t most) {
    check(points, size, most);
    const auto &[unit, value, variance, weight] = points;
    const double half = 0.5 * static_cast<double>(size);
    const auto last = static_cast<double>(size - 1);
    std::vector<std::uint32_t> key(unit.size());
    std::vector<Cell> cells(size * size);
    for (std::size_t i = 0; i < unit.size(); ++i) {
        const double scale = 1.0 / std::sqrt(1.0 + unit[i].z);
        key[i] = static_cast<std::uint32_t>(cell_of(unit[i].y * scale, half, last) * size +
                                            cell_of(unit[i].x * scale, half, last));
        cells[key[i]].add(weight[i], value[i], variance[i]);
    }
    for (Cell &cell : cells) {
        cell.thin(most);
    }
    std::vector<std::uint32_t> kept;
    kept.reserve(unit.size());
    std::vector<std::int64_t> next(size * size + 1, 0);
    for (std::size_t i = 0; i < unit.size(); ++i) {
        Cell &cell = cells[key[i]];
        if (cell.points++ % cell.every != 0) {
            continue;
        }
        kept.push_back(static_cast<std::uint32_t>(i));
        ++next[key[i] + 1];
        const double w = weight[i];
        const std::array<double, 6> own{
            w, w * value[i], w * w * variance[i], w * unit[i].x, w * unit[i].y, w * unit[i].z};
        for (std::size_t k = 0; k < own.size(); ++k) {
            cell.sum[k] += own[k];
        }
    }
    Sorted_cells sorted;
    sorted.start.push_back(0);
    for (std::size_t c = 0; c < cells.size(); ++c) {
        if (next[c + 1] > 0) {
            Cell &cell = cells[c];
            // from here on what the weights of those that stay are multiplied by
            cell.weight = cell.every > 1 ? cell.weight / cell.sum[0] : 1.0;
            auto &sum = sorted.sum.emplace_back(cell.sum);
            for (std::size_t k = 0; k < sum.size(); ++k) {
                sum[k] *= k == 2 ? cell.weight * cell.weight : cell.weight;
            }
            sorted.home.push_back(static_cast<std::int64_t>(c));
            sorted.start.push_back(next[c] + next[c + 1]);
        }
        next[c + 1] += next[c];
    }
    sorted.row.resize(kept.size());
    sorted.weight.resize(kept.size());
    for (const std::uint32_t i : kept) {
        const auto to = static_cast<std::size_t>(next[key[i]]++);
        sorted.row[to] = static_cast<std::int64_t>(i);
        sorted.weight[to] = weight[i] * cells[key[i]].weight;
    }
    return sorted;
}

} // namespace gonio::model
