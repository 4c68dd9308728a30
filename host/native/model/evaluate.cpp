// evaluate.cpp: sums of lobes, of what is left beside them and of backgrounds. Most lobes are far from most directions:
// one product with their centre tells.
#include "evaluate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "azimuthal.hpp"
#include "bilinear.hpp"
#include "threads.hpp"

namespace gonio::model {
namespace {

constexpr double LOBE_REACH = 8.5;       // standard deviations
constexpr double PATCH_HALF_WIDTH = 4.0; // the same
constexpr double LEAST_COSINE = 0.05;

// Where a lobe is looked for at all.
struct Reach {
    Vec centre;
    double cosine;
};

struct Field {
    const float *nodes;
    std::ptrdiff_t size;
    double half_cells;
    double weight;
    std::array<double, 4> matrix;
    std::array<double, 2> shift;
    bool as_bsdf;
    bool shifted;
    bool beside; // read where the slice's field before it is
};

struct Patch {
    const float *nodes;
    std::ptrdiff_t size;
    double cells_per_sigma;
    double weight;
};

class Evaluator {
public:
    Evaluator(const Slices &slices, const Grids &grids) : slices_(slices) {
        for (std::size_t l = 0; l < slices.lobe_peak.size(); ++l) {
            // An angle longer than this is more than LOBE_REACH along the longer axis too.
            const double angle = LOBE_REACH / least_stretch(&slices.lobe_whitening[4 * l]);
            const double cosine = angle < std::numbers::pi ? std::cos(angle) - 1e-12 : -2.0;
            reach_.push_back({slices.lobe_frame[3 * l + 2], cosine});
        }
        for (std::size_t p = 0; p < slices.patch_weight.size(); ++p) {
            const auto g = static_cast<std::size_t>(slices.patch_grid[p]);
            const auto size = static_cast<std::ptrdiff_t>(grids.size[g]);
            patches_.push_back({&grids.values[static_cast<std::size_t>(grids.start[g])], size,
                                static_cast<double>(size - 1) / (2.0 * PATCH_HALF_WIDTH), slices.patch_weight[p]});
        }
        for (std::size_t f = 0; f < slices.field_weight.size(); ++f) {
            const auto g = static_cast<std::size_t>(slices.field_grid[f]);
            const auto size = static_cast<std::ptrdiff_t>(grids.size[g]);
            const double *const m = &slices.field_matrix[4 * f];
            const double *const s = &slices.field_shift[2 * f];
            fields_.push_back({&grids.values[static_cast<std::size_t>(grids.start[g])],
                               size,
                               0.5 * static_cast<double>(size - 1),
                               slices.field_weight[f],
                               {m[0], m[1], m[2], m[3]},
                               {s[0], s[1]},
                               slices.field_as_bsdf[f],
                               s[0] != 0.0 || s[1] != 0.0,
                               false});
        }
        for (std::size_t s = 0; s < slices.scale.size(); ++s) {
            for (auto f = slices.field_start[s] + 1; f < slices.field_start[s + 1]; ++f) {
                Field &one = fields_[static_cast<std::size_t>(f)];
                const Field &before = fields_[static_cast<std::size_t>(f) - 1];
                one.beside = one.matrix == before.matrix && one.shift == before.shift;
            }
        }
    }

    double dsf(std::size_t slice, const Vec &unit) const {
        double total = backgrounds(slice, unit);
        const auto last = static_cast<std::size_t>(slices_.lobe_start[slice + 1]);
        for (auto l = static_cast<std::size_t>(slices_.lobe_start[slice]); l < last; ++l) {
            const double z = dot(reach_[l].centre, unit);
            if (z >= reach_[l].cosine) {
                total += lobe(l, z, unit);
            }
        }
        return total > 0.0 ? slices_.scale[slice] * total : 0.0;
    }

private:
    const Slices &slices_;
    std::vector<Reach> reach_;
    std::vector<Patch> patches_;
    std::vector<Field> fields_;

    double lobe(std::size_t l, double z, const Vec &unit) const {
        double x = dot(slices_.lobe_frame[3 * l], unit);
        const double y = dot(slices_.lobe_frame[3 * l + 1], unit);
        const double *const w = &slices_.lobe_whitening[4 * l];
        double first = w[0] * x + w[1] * y;
        double second = w[2] * x + w[3] * y;
        if (first * first + second * second > LOBE_REACH * LOBE_REACH) { // the angle is longer than its sine
            return 0.0;
        }
        const double longer = stretch(x, y, z);
        first = longer * (w[0] * x + w[1] * y);
        second = longer * (w[2] * x + w[3] * y);
        const double r2 = first * first + second * second;
        if (!(r2 <= LOBE_REACH * LOBE_REACH)) {
            return 0.0;
        }
        double total = slices_.lobe_peak[l] * std::exp(-0.5 * r2);
        if (std::fabs(first) <= PATCH_HALF_WIDTH && std::fabs(second) <= PATCH_HALF_WIDTH) {
            const auto last = static_cast<std::size_t>(slices_.patch_start[l + 1]);
            for (auto p = static_cast<std::size_t>(slices_.patch_start[l]); p < last; ++p) {
                const Patch &one = patches_[p];
                total += one.weight * bilinear(one.nodes, one.size, (first + PATCH_HALF_WIDTH) * one.cells_per_sigma,
                                               (second + PATCH_HALF_WIDTH) * one.cells_per_sigma);
            }
        }
        return total;
    }

    double backgrounds(std::size_t slice, const Vec &unit) const {
        double total = 0.0;
        double x = 0.0;
        double y = 0.0;
        double z = 1.0;
        const auto last = static_cast<std::size_t>(slices_.field_start[slice + 1]);
        for (auto f = static_cast<std::size_t>(slices_.field_start[slice]); f < last; ++f) {
            const Field &one = fields_[f];
            if (!one.beside) {
                x = one.matrix[0] * unit.x + one.matrix[1] * unit.y + one.shift[0];
                y = one.matrix[2] * unit.x + one.matrix[3] * unit.y + one.shift[1];
                z = unit.z;
                if (one.shifted) {
                    const double r2 = x * x + y * y;
                    z = std::sqrt(std::max(1.0 - r2, 0.0));
                    if (r2 > 1.0) {
                        const double r = std::sqrt(r2);
                        x /= r;
                        y /= r;
                    }
                }
                const double to_disc = 1.0 / std::sqrt(1.0 + z);
                x *= to_disc;
                y *= to_disc;
            }
            double value =
                one.weight * bilinear(one.nodes, one.size, (x + 1.0) * one.half_cells, (y + 1.0) * one.half_cells);
            if (one.as_bsdf) {
                value *= unit.z / std::max(z, LEAST_COSINE);
            }
            total += value;
        }
        return total;
    }
};

} // namespace

void evaluate(const Slices &slices, const Grids &grids, std::span<const Vec> unit, std::span<const std::int64_t> which,
              std::span<double> dsf) {
    check(slices, grids);
    if (!which.empty() && which.size() != unit.size()) {
        throw std::invalid_argument("one slice per direction is needed");
    }
    if (!unit.empty() && slices.scale.empty()) {
        throw std::invalid_argument("there is no slice");
    }
    const Evaluator model(slices, grids);
    sphere::in_threads(unit.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::int64_t slice = which.empty() ? 0 : which[i];
            if (slice < 0 || static_cast<std::size_t>(slice) >= slices.scale.size()) {
                throw std::invalid_argument("there is no such slice");
            }
            const bool direction = std::fabs(dot(unit[i], unit[i]) - 1.0) < 1e-6;
            dsf[i] = direction ? model.dsf(static_cast<std::size_t>(slice), unit[i])
                               : std::numeric_limits<double>::quiet_NaN();
        }
    });
}

} // namespace gonio::model
