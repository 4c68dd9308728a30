// thin_plate.cpp: least energy of a plate by a decomposition of its banded matrix (A.-L. Cholesky's).
#include "thin_plate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace gonio::model {
namespace {

constexpr double MEMBRANE = 1e-3;
constexpr double BEYOND = 0.25;                // of the known values' range
constexpr std::size_t SOFT = 4;                // nodes around a hole
constexpr double MEDIAN_OF_SQUARE = 0.4549364; // of a normal variable of variance 1
constexpr double LEAST_BENDING = 0.05;         // of the second differences' variance is not noise
constexpr double STIFFEST = 1e-6;              // of the bending's variance that a node is known to

// One difference whose square is part of the energy: row and column from a node, coefficient.
struct Term {
    std::size_t row;
    std::size_t column;
    double times;
};
struct Difference {
    double weight;
    std::size_t count;
    std::array<Term, 4> term;
};
constexpr std::array<Difference, 5> DIFFERENCES = {{
    {1.0, 3, {{{0, 0, 1.0}, {0, 1, -2.0}, {0, 2, 1.0}}}},
    {1.0, 3, {{{0, 0, 1.0}, {1, 0, -2.0}, {2, 0, 1.0}}}},
    {2.0, 4, {{{0, 0, 1.0}, {0, 1, -1.0}, {1, 0, -1.0}, {1, 1, 1.0}}}},
    {MEMBRANE, 2, {{{0, 0, 1.0}, {0, 1, -1.0}}}},
    {MEMBRANE, 2, {{{0, 0, 1.0}, {1, 0, -1.0}}}},
}};
constexpr std::size_t BENDING = 2; // the first ones: plain second differences

// A symmetric positive matrix: row i holds the diagonal and what is right of it.
class Banded {
public:
    Banded(std::size_t rows, std::size_t band) : rows_(rows), wide_(band + 1), entry_(rows * wide_, 0.0) {}

    double &at(std::size_t row, std::size_t column) { return entry_[row * wide_ + column - row]; }

    // Replaces the right-hand side by the solution, and the matrix by its factors.
    void solve(std::vector<double> &right) {
        for (std::size_t j = 0; j < rows_; ++j) {
            const double *const pivot = &entry_[j * wide_];
            const std::size_t last = std::min(wide_, rows_ - j);
            for (std::size_t i = 1; i < last; ++i) {
                const double factor = pivot[i] / pivot[0];
                if (factor == 0.0) {
                    continue;
                }
                double *const row = &entry_[(j + i) * wide_];
                for (std::size_t k = i; k < last; ++k) {
                    row[k - i] -= factor * pivot[k];
                }
                right[j + i] -= factor * right[j];
            }
        }
        for (std::size_t j = rows_; j-- > 0;) {
            const double *const pivot = &entry_[j * wide_];
            for (std::size_t i = 1; i < std::min(wide_, rows_ - j); ++i) {
                right[j] -= pivot[i] * right[j + i];
            }
            right[j] /= pivot[0];
        }
    }

private:
    std::size_t rows_;
    std::size_t wide_;
    std::vector<double> entry_;
};

// Calls visit(difference, nodes) for every one of a kind that lies within the grid.
template <typename Visit> void for_each(const Difference &kind, std::size_t size, const Visit &visit) {
    const Term &last = kind.term[kind.count - 1];
    for (std::size_t row = 0; row + last.row < size; ++row) {
        for (std::size_t column = 0; column + last.column < size; ++column) {
            std::array<std::size_t, 4> node{};
            for (std::size_t k = 0; k < kind.count; ++k) {
                node[k] = (row + kind.term[k].row) * size + column + kind.term[k].column;
            }
            visit(kind, node);
        }
    }
}

double median(std::vector<double> &of) {
    const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
    std::nth_element(of.begin(), middle, of.end());
    return *middle;
}

// Variance of the second differences of the known nodes beyond what noise gives them.
double bending(std::span<const double> nodes, std::span<const unsigned char> known, std::span<const double> variance,
               std::size_t size) {
    std::vector<double> squares;
    std::vector<double> noises;
    for (std::size_t kind = 0; kind < BENDING; ++kind) {
        for_each(DIFFERENCES[kind], size, [&](const Difference &one, const std::array<std::size_t, 4> &node) {
            double sum = 0.0;
            double noise = 0.0;
            for (std::size_t k = 0; k < one.count; ++k) {
                if (known[node[k]] == 0) {
                    return;
                }
                sum += one.term[k].times * nodes[node[k]];
                noise += one.term[k].times * one.term[k].times * variance[node[k]];
            }
            squares.push_back(sum * sum);
            noises.push_back(noise);
        });
    }
    if (squares.empty()) {
        return 0.0;
    }
    const double all = median(squares) / MEDIAN_OF_SQUARE;
    return std::max(all - median(noises), LEAST_BENDING * all);
}

// Marks the holes, and with springs the nodes around them.
std::vector<unsigned char> free_nodes(std::span<const unsigned char> known, bool springs, std::size_t size) {
    std::vector<unsigned char> free(known.size(), 0);
    for (std::size_t row = 0; row < size; ++row) {
        for (std::size_t column = 0; column < size; ++column) {
            if (known[row * size + column] != 0) {
                continue;
            }
            const std::size_t reach = springs ? SOFT : 0;
            for (std::size_t i = row - std::min(row, reach); i < std::min(row + reach + 1, size); ++i) {
                for (std::size_t j = column - std::min(column, reach); j < std::min(column + reach + 1, size); ++j) {
                    free[i * size + j] = 1;
                }
            }
        }
    }
    return free;
}

} // namespace

void span_holes(std::vector<double> &nodes, std::span<const unsigned char> known, std::span<const double> variance,
                std::size_t size) {
    double lowest = HUGE_VAL;
    double highest = -HUGE_VAL;
    bool whole = true;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        if (known[k] != 0) {
            lowest = std::min(lowest, nodes[k]);
            highest = std::max(highest, nodes[k]);
        }
        whole = whole && known[k] != 0;
    }
    if (whole || lowest > highest) {
        return;
    }
    const double give = variance.empty() ? 0.0 : bending(nodes, known, variance, size);
    const std::vector<unsigned char> free = free_nodes(known, give > 0.0, size);
    std::vector<std::size_t> number(nodes.size());
    std::vector<std::size_t> open;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        if (free[k] != 0) {
            number[k] = open.size();
            open.push_back(k);
        }
    }
    std::size_t band = 0;
    const auto widen = [&](const Difference &one, const std::array<std::size_t, 4> &node) {
        for (std::size_t a = 0; a < one.count; ++a) {
            for (std::size_t b = 0; b < a; ++b) {
                if (free[node[a]] != 0 && free[node[b]] != 0) {
                    band = std::max(band, number[node[a]] - number[node[b]]);
                }
            }
        }
    };
    for (const Difference &kind : DIFFERENCES) {
        for_each(kind, size, widen);
    }
    Banded matrix(open.size(), band);
    std::vector<double> height(open.size(), 0.0);
    const auto add = [&](const Difference &one, const std::array<std::size_t, 4> &node) {
        for (std::size_t a = 0; a < one.count; ++a) {
            if (free[node[a]] == 0) {
                continue;
            }
            for (std::size_t b = 0; b < one.count; ++b) {
                const double product = one.weight * one.term[a].times * one.term[b].times;
                if (free[node[b]] == 0) {
                    height[number[node[a]]] -= product * nodes[node[b]];
                } else if (b >= a) {
                    matrix.at(number[node[a]], number[node[b]]) += product;
                }
            }
        }
    };
    for (const Difference &kind : DIFFERENCES) {
        for_each(kind, size, add);
    }
    for (std::size_t k = 0; k < open.size(); ++k) {
        if (known[open[k]] != 0) {
            const double spring = give / std::max(variance[open[k]], STIFFEST * give);
            matrix.at(k, k) += spring;
            height[k] += spring * nodes[open[k]];
        }
    }
    matrix.solve(height);
    const double margin = BEYOND * (highest - lowest);
    for (std::size_t k = 0; k < open.size(); ++k) {
        if (known[open[k]] == 0) {
            nodes[open[k]] = std::clamp(height[k], lowest - margin, highest + margin);
        }
    }
}

} // namespace gonio::model
