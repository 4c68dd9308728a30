// local_fit.cpp: least squares of a cubic, or a quadratic, to the clusters around a direction.
#include "local_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>

#include "threads.hpp"

namespace gonio::sphere {
namespace {

constexpr double CELL = 0.4; // of the radius
constexpr std::size_t FEWEST = 12;
constexpr std::size_t FEWEST_FOR_CUBIC = 16;
constexpr int QUADRATIC = 6;
constexpr int CUBIC = 10;
constexpr double GROWTH = 1.4142135623730951;
constexpr int LEVELS = 11;
constexpr double WIDEST_RAD = 0.5;
constexpr double WIDER = 2.0;        // where a radius does not do, as at borders, so much more with the same cells
constexpr double INDEPENDENT = 1e-3; // least share of a column of the fit that the columns before it may leave

struct Row {
    std::array<double, CUBIC> mean; // of 1, x, y, x^2/2, xy, y^2/2, x^3/6, x^2 y/2, x y^2/2, y^3/6
    double weight;
    double value;
    double variance;
};

double product_mean(const std::array<double, 6> &p, const Vec &u, const Vec &v) {
    return p[0] * u.x * v.x + p[1] * u.y * v.y + p[2] * u.z * v.z + p[3] * (u.x * v.y + u.y * v.x) +
           p[4] * (u.x * v.z + u.z * v.x) + p[5] * (u.y * v.z + u.z * v.y);
}

// Means over a cluster in the tangent plane's coordinates, in units of the radius. Third powers: as if the points lay
// evenly about their mean.
Row row_of(const Cluster &cluster, const Vec &at, const Vec &e1, const Vec &e2, double reach) {
    const Vec apart = cluster.unit - at;
    const double near = 1.0 - dot(apart, apart) / (reach * reach);
    const double x = dot(cluster.unit, e1) / reach;
    const double y = dot(cluster.unit, e2) / reach;
    const double xx = product_mean(cluster.products, e1, e1) / (reach * reach);
    const double xy = product_mean(cluster.products, e1, e2) / (reach * reach);
    const double yy = product_mean(cluster.products, e2, e2) / (reach * reach);
    return {{1.0, x, y, 0.5 * xx, xy, 0.5 * yy, (3.0 * x * xx - 2.0 * x * x * x) / 6.0,
             0.5 * (2.0 * x * xy + y * xx - 2.0 * x * x * y), 0.5 * (2.0 * y * xy + x * yy - 2.0 * x * y * y),
             (3.0 * y * yy - 2.0 * y * y * y) / 6.0},
            near * near,
            cluster.value,
            cluster.variance};
}

// The lower triangle of the normal equations' matrix, and its decomposition by A.-L. Cholesky.
struct Normal {
    std::array<std::array<double, CUBIC>, CUBIC> matrix{};
    std::array<double, CUBIC> right{};

    void add(const Row &row) {
        for (int i = 0; i < CUBIC; ++i) {
            const double weighted = row.weight * row.mean[i];
            right[i] += weighted * row.value;
            for (int j = 0; j <= i; ++j) {
                matrix[i][j] += weighted * row.mean[j];
            }
        }
    }

    // How many columns, 10 or 6, the rows fix; 0 where not even 6.
    int decompose(int wanted) {
        const double sum = matrix[0][0];
        for (int j = 0; j < wanted; ++j) {
            double pivot = matrix[j][j];
            // Along a line the other coordinate is next to nothing: it has to be something on the scale of the radius.
            const double least = INDEPENDENT * (j == 1 || j == 2 ? std::max(pivot, sum) : pivot);
            for (int k = 0; k < j; ++k) {
                pivot -= matrix[j][k] * matrix[j][k];
            }
            if (!(pivot > least)) {
                return j < QUADRATIC ? 0 : QUADRATIC;
            }
            matrix[j][j] = std::sqrt(pivot);
            for (int i = j + 1; i < wanted; ++i) {
                double rest = matrix[i][j];
                for (int k = 0; k < j; ++k) {
                    rest -= matrix[i][k] * matrix[j][k];
                }
                matrix[i][j] = rest / matrix[j][j];
            }
        }
        return wanted;
    }

    [[nodiscard]] std::array<double, CUBIC> solve(std::array<double, CUBIC> b, int columns) const {
        for (int i = 0; i < columns; ++i) {
            for (int k = 0; k < i; ++k) {
                b[i] -= matrix[i][k] * b[k];
            }
            b[i] /= matrix[i][i];
        }
        for (int i = columns - 1; i >= 0; --i) {
            for (int k = i + 1; k < columns; ++k) {
                b[i] -= matrix[k][i] * b[k];
            }
            b[i] /= matrix[i][i];
        }
        return b;
    }
};

// Clusters of all sizes, each made of the smaller ones when it is first needed.
class Pyramid {
public:
    Pyramid(std::span<const Cluster> points, double radius) : points_(points), radius_(radius) {}

    [[nodiscard]] double reach(int level) const { return radius_ * std::pow(GROWTH, level); }

    const Clusters &level(int number) {
        std::call_once(made_[number], [&] {
            levels_[number] =
                std::make_unique<Clusters>(number == 0 ? points_ : level(number - 1).all(), CELL * reach(number));
        });
        return *levels_[number];
    }

private:
    std::span<const Cluster> points_;
    double radius_;
    std::array<std::once_flag, LEVELS> made_;
    std::array<std::unique_ptr<Clusters>, LEVELS> levels_;
};

// Fits about one direction after the other; the next one most often needs the same radius.
class Fitter {
public:
    explicit Fitter(Pyramid &pyramid) : pyramid_(pyramid) {}

    Fit about(const Vec &at) {
        std::optional<Fit> fit = fit_at(at, hint_);
        if (fit) {
            while (hint_ > 0) {
                const std::optional<Fit> nearer = fit_at(at, hint_ - 1);
                if (!nearer) {
                    break;
                }
                fit = nearer;
                --hint_;
            }
            return *fit;
        }
        for (int level = hint_ + 1; level < LEVELS && pyramid_.reach(level) <= WIDEST_RAD; ++level) {
            fit = fit_at(at, level);
            if (fit) {
                hint_ = level;
                return *fit;
            }
        }
        constexpr double NONE = std::numeric_limits<double>::quiet_NaN();
        return {NONE, {NONE, NONE, NONE}, {NONE, NONE, NONE, NONE, NONE, NONE}, NONE};
    }

private:
    std::optional<Fit> fit_at(const Vec &at, int level) {
        std::optional<Fit> fit = fit_within(at, level, pyramid_.reach(level));
        return fit ? fit : fit_within(at, level, WIDER * pyramid_.reach(level));
    }

    std::optional<Fit> fit_within(const Vec &at, int level, double reach) {
        pyramid_.level(level).near(at, reach, near_);
        if (near_.size() < FEWEST) {
            return std::nullopt;
        }
        const Tangents frame = tangents(at);
        rows_.clear();
        Normal normal;
        for (const Cluster *cluster : near_) {
            rows_.push_back(row_of(*cluster, at, frame.e1, frame.e2, reach));
            normal.add(rows_.back());
        }
        const int columns = normal.decompose(near_.size() < FEWEST_FOR_CUBIC ? QUADRATIC : CUBIC);
        if (columns == 0) {
            return std::nullopt;
        }
        const std::array<double, CUBIC> c = normal.solve(normal.right, columns);
        // What each row's value does to the two components of the gradient.
        const std::array<double, CUBIC> by_x = normal.solve({0.0, 1.0}, columns);
        const std::array<double, CUBIC> by_y = normal.solve({0.0, 0.0, 1.0}, columns);
        double variance = 0.0;
        for (const Row &row : rows_) {
            double x = 0.0;
            double y = 0.0;
            for (int k = 0; k < columns; ++k) {
                x += by_x[k] * row.mean[k];
                y += by_y[k] * row.mean[k];
            }
            variance += 0.5 * row.weight * row.weight * (x * x + y * y) * row.variance;
        }
        const double per_square = 1.0 / (reach * reach);
        const auto bend = [&](int i, int j) {
            return per_square * (c[3] * component(frame.e1, i) * component(frame.e1, j) +
                                 c[4] * (component(frame.e1, i) * component(frame.e2, j) +
                                         component(frame.e2, i) * component(frame.e1, j)) +
                                 c[5] * component(frame.e2, i) * component(frame.e2, j));
        };
        return Fit{c[0],
                   (c[1] / reach) * frame.e1 + (c[2] / reach) * frame.e2,
                   {bend(0, 0), bend(1, 1), bend(2, 2), bend(0, 1), bend(0, 2), bend(1, 2)},
                   variance * per_square};
    }

    Pyramid &pyramid_;
    int hint_ = 0;
    std::vector<const Cluster *> near_;
    std::vector<Row> rows_;
};

} // namespace

std::vector<Fit> local_fits(std::span<const Vec> unit, std::span<const Cluster> points, double radius) {
    std::vector<Fit> result(unit.size());
    Pyramid pyramid(points, radius);
    in_threads(unit.size(), [&](std::size_t begin, std::size_t end) {
        Fitter fitter(pyramid);
        for (std::size_t i = begin; i < end; ++i) {
            result[i] = fitter.about(unit[i]);
        }
    });
    return result;
}

} // namespace gonio::sphere
