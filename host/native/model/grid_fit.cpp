// grid_fit.cpp: from one cell to the finest, each level corrects what the coarser one leaves over.
#include "grid_fit.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "grid_moments.hpp"
#include "thin_plate.hpp"

namespace gonio::model {
namespace {

constexpr int PASSES = 2;
constexpr int PASSES_FINEST = 4;
constexpr double HESITATION = 0.02; // a node whose cells have points, but near their other corners, follows them less
constexpr double CAUTION = 2.0;     // times the variance that noise is taken to have
constexpr std::size_t CELLS_SPANNED = 32; // of the level at which holes are spanned
constexpr double KNOWN = 0.1;             // least share of the cells' points that a node has to be no hole

using Nodes = std::vector<double>;

// What a cell gives to its nodes at (0, 0), (1, 0), (0, 1), (1, 1).
using Corners = std::array<double, 4>;

void give(Nodes &to, std::size_t size, std::size_t node, const Corners &what) {
    to[node] += what[0];
    to[node + 1] += what[1];
    to[node + size] += what[2];
    to[node + size + 1] += what[3];
}

// Calls visit(cell, its first node) for every cell with points.
template <typename Visit> void for_each_cell(const Level &level, const Visit &visit) {
    for (std::size_t row = 0; row < level.cells; ++row) {
        for (std::size_t column = 0; column < level.cells; ++column) {
            const std::size_t cell = row * level.cells + column;
            if (level.cell[cell].mass[0] > 0.0) {
                visit(cell, row * (level.cells + 1) + column);
            }
        }
    }
}

Level finest(const Scattered &points, double half_width, std::size_t cells) {
    const bool noisy = std::any_of(points.variance.begin(), points.variance.end(), [](double v) { return v > 0.0; });
    Level level{cells, std::vector<Cell>(cells * cells), {}};
    level.noise.resize(noisy ? cells * cells : 0);
    const double half = 0.5 * static_cast<double>(cells);
    const auto last = static_cast<double>(cells - 1);
    for (std::size_t i = 0; i < points.value.size(); ++i) {
        const double weight = points.weight[i];
        const auto &[at_x, at_y] = points.position[i];
        if (!(weight > 0.0) || !std::isfinite(points.value[i]) || !(std::fabs(at_x) <= half_width) ||
            !(std::fabs(at_y) <= half_width)) {
            continue;
        }
        double x = (at_x / half_width + 1.0) * half;
        double y = (at_y / half_width + 1.0) * half;
        const double column = std::floor(std::clamp(x, 0.0, last));
        const double row = std::floor(std::clamp(y, 0.0, last));
        x = std::clamp(x - column, 0.0, 1.0);
        y = std::clamp(y - row, 0.0, 1.0);
        const std::array<double, 3> powers_x{1.0, x, x * x};
        const std::array<double, 3> powers_y{1.0, y, y * y};
        const std::size_t number = static_cast<std::size_t>(row) * cells + static_cast<std::size_t>(column);
        Cell &cell = level.cell[number];
        const double load = weight * points.value[i];
        const double noise = weight * weight * points.variance[i];
        for (std::size_t b = 0; b < 3; ++b) {
            for (std::size_t a = 0; a < 3; ++a) {
                const double power = powers_x[a] * powers_y[b];
                cell.mass[a + 3 * b] += weight * power;
                if (noisy) {
                    level.noise[number][a + 3 * b] += noise * power;
                }
            }
        }
        cell.load[0] += load;
        cell.load[1] += load * x;
        cell.load[2] += load * y;
        cell.load[3] += load * x * y;
    }
    return level;
}

// The same bilinear function on nodes half as far apart.
Nodes finer(const Nodes &coarse, std::size_t size) {
    const std::size_t wide = 2 * size - 1;
    Nodes result(wide * wide);
    for (std::size_t i = 0; i < size; ++i) {
        for (std::size_t j = 0; j < size; ++j) {
            result[2 * i * wide + 2 * j] = coarse[i * size + j];
        }
    }
    for (std::size_t i = 1; i < wide; i += 2) {
        for (std::size_t j = 0; j < wide; j += 2) {
            result[i * wide + j] = 0.5 * (result[(i - 1) * wide + j] + result[(i + 1) * wide + j]);
        }
    }
    for (std::size_t i = 0; i < wide; ++i) {
        for (std::size_t j = 1; j < wide; j += 2) {
            result[i * wide + j] = 0.5 * (result[i * wide + j - 1] + result[i * wide + j + 1]);
        }
    }
    return result;
}

// Replaces every value by the sum over it and its neighbours with the weights 1 4 6 4 1 along both coordinates.
void gather(Nodes &of, std::size_t size) {
    const auto sweep = [&](Nodes &line, std::size_t start, std::size_t step) {
        for (std::size_t k = 0; k < size; ++k) {
            line[k + 2] = of[start + k * step];
        }
        for (std::size_t k = 0; k < size; ++k) {
            of[start + k * step] = line[k] + line[k + 4] + 4.0 * (line[k + 1] + line[k + 3]) + 6.0 * line[k + 2];
        }
    };
    Nodes line(size + 4, 0.0);
    for (std::size_t i = 0; i < size; ++i) {
        sweep(line, i, size);
    }
    for (std::size_t i = 0; i < size; ++i) {
        sweep(line, i * size, 1);
    }
}

// Of the nodes of a level: what the residuals about each are divided by (0 where there are none), and the variance that
// noise gives to their mean.
struct Ground {
    Nodes divisor;
    Nodes own_variance; // of each node
    Nodes variance;     // gathered
};

Ground ground_of(const Level &level) {
    const std::size_t size = level.cells + 1;
    Ground ground{Nodes(size * size), Nodes(level.noise.empty() ? 0 : size * size), {}};
    for_each_cell(level, [&](std::size_t cell, std::size_t node) {
        const Moments<3> &m = level.cell[cell].mass;
        const double least = HESITATION * m[0];
        give(ground.divisor, size, node,
             {m[0] - m[1] - m[3] + m[4] + least, m[1] - m[4] + least, m[3] - m[4] + least, m[4] + least});
        if (!level.noise.empty()) {
            const Moments<3> &s = level.noise[cell];
            const double at_0 = s[0] - 2.0 * s[3] + s[6]; // times (1 - y)^2
            const double at_1 = s[1] - 2.0 * s[4] + s[7];
            const double at_2 = s[2] - 2.0 * s[5] + s[8];
            give(ground.own_variance, size, node, {at_0 - 2.0 * at_1 + at_2, at_2, s[6] - 2.0 * s[7] + s[8], s[8]});
        }
    });
    if (!level.noise.empty()) {
        for (std::size_t k = 0; k < ground.divisor.size(); ++k) {
            const double d = ground.divisor[k];
            ground.own_variance[k] = d > 0.0 ? std::max(ground.own_variance[k], 0.0) / (d * d) : 0.0;
        }
        ground.variance = ground.own_variance;
        gather(ground.variance, size);
    }
    return ground;
}

void span(Nodes &nodes, const Level &level, const Ground &ground) {
    const std::size_t size = level.cells + 1;
    Nodes share(nodes.size());
    Nodes around(nodes.size());
    for_each_cell(level, [&](std::size_t cell, std::size_t node) {
        const Moments<3> &m = level.cell[cell].mass;
        give(share, size, node, {m[0] - m[1] - m[3] + m[4], m[1] - m[4], m[3] - m[4], m[4]});
        give(around, size, node, {m[0], m[0], m[0], m[0]});
    });
    std::vector<unsigned char> known(nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        known[k] = around[k] > 0.0 && share[k] >= KNOWN * around[k] ? 1 : 0;
    }
    span_holes(nodes, known, ground.own_variance, size);
}

void correct(Nodes &nodes, const Level &level, const Ground &ground) {
    const std::size_t size = level.cells + 1;
    Nodes step(size * size, 0.0);
    for_each_cell(level, [&](std::size_t cell, std::size_t node) {
        const auto &[m, load] = level.cell[cell];
        const double constant = nodes[node];
        const double along_x = nodes[node + 1] - constant;
        const double along_y = nodes[node + size] - constant;
        const double along_xy = nodes[node + size + 1] - nodes[node + size] - along_x;
        Corners left;
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t at = k % 2 + 3 * (k / 2);
            left[k] = load[k] - constant * m[at] - along_x * m[at + 1] - along_y * m[at + 3] - along_xy * m[at + 4];
        }
        give(step, size, node, {left[0] - left[1] - left[2] + left[3], left[1] - left[3], left[2] - left[3], left[3]});
    });
    for (std::size_t k = 0; k < step.size(); ++k) {
        step[k] = ground.divisor[k] > 0.0 ? step[k] / ground.divisor[k] : 0.0;
    }
    if (level.noise.empty()) {
        for (std::size_t k = 0; k < step.size(); ++k) {
            nodes[k] += step[k];
        }
        return;
    }
    Nodes power(step.size());
    std::transform(step.begin(), step.end(), power.begin(), [](double s) { return s * s; });
    gather(power, size);
    for (std::size_t k = 0; k < step.size(); ++k) {
        if (power[k] > CAUTION * ground.variance[k]) {
            nodes[k] += step[k] * (1.0 - CAUTION * ground.variance[k] / power[k]);
        }
    }
}

} // namespace

std::vector<double> fit_grid(const Scattered &points, double half_width, std::size_t size) {
    const std::size_t n = points.position.size();
    if (points.value.size() != n || points.variance.size() != n || points.weight.size() != n) {
        throw std::invalid_argument("one value, variance and weight per position is needed");
    }
    if (size < 2 || !std::has_single_bit(size - 1)) {
        throw std::invalid_argument("a grid has 2^p + 1 nodes along each side");
    }
    std::vector<Level> levels;
    levels.push_back(finest(points, half_width, size - 1));
    while (levels.back().cells > 1) {
        levels.push_back(coarser(levels.back()));
    }
    const Cell &all = levels.back().cell.front();
    if (!(all.mass[0] > 0.0)) {
        return Nodes(size * size, 0.0);
    }
    Nodes nodes(4, all.load[0] / all.mass[0]);
    while (!levels.empty()) {
        const Level &level = levels.back();
        if (level.cells > 1) {
            nodes = finer(nodes, level.cells / 2 + 1);
        }
        const Ground ground = ground_of(level);
        for (int pass = 0; pass < (levels.size() > 1 ? PASSES : PASSES_FINEST); ++pass) {
            correct(nodes, level, ground);
        }
        if (level.cells == std::min(CELLS_SPANNED, size - 1)) {
            span(nodes, level, ground);
        }
        levels.pop_back();
    }
    return nodes;
}

} // namespace gonio::model
