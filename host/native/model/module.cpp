// module.cpp: the Python module _model: models evaluated and grids fitted, with numpy arrays in and out. Python's lock
// is released meanwhile. What it offers is described in host/gonio/model/_model.pyi.
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/tuple.h>

#include "bilinear.hpp"
#include "evaluate.hpp"
#include "grid_fit.hpp"
#include "near_lobes.hpp"
#include "sorted_cells.hpp"
#include "suitable_size.hpp"
#include "threads.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace gonio::model {
namespace {

template <typename T> using Column_in = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <typename T, long... Width>
using Rows_in = nb::ndarray<const T, nb::shape<-1, Width...>, nb::c_contig, nb::device::cpu>;
using Floats = Column_in<double>;
using Numbers = Column_in<std::int64_t>;
using Square_in = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

static_assert(sizeof(Vec) == 3 * sizeof(double) && sizeof(Place) == 2 * sizeof(double));

template <typename T> std::span<const T> span(const Column_in<T> &column) {
    return {column.data(), column.shape(0)};
}

std::span<const Place> places(const Rows_in<double, 2> &rows) {
    return {reinterpret_cast<const Place *>(rows.data()), rows.shape(0)};
}

// Arrays that take over a vector's memory.
template <typename T, std::size_t Dimensions>
nb::ndarray<nb::numpy, T, nb::ndim<Dimensions>> taken(std::vector<T> &&held,
                                                      const std::array<std::size_t, Dimensions> &shape) {
    auto owned = std::make_unique<std::vector<T>>(std::move(held));
    T *const data = owned->data();
    const nb::capsule owner(owned.release(), [](void *one) noexcept { delete static_cast<std::vector<T> *>(one); });
    return nb::ndarray<nb::numpy, T, nb::ndim<Dimensions>>(data, Dimensions, shape.data(), owner);
}

auto evaluated(const std::tuple<Floats, Numbers, Numbers> &slices,
               const std::tuple<Rows_in<double, 3, 3>, Rows_in<double, 2, 2>, Floats, Numbers> &lobes,
               const std::tuple<Numbers, Floats> &patches,
               const std::tuple<Numbers, Floats, Rows_in<double, 2, 2>, Rows_in<double, 2>, Column_in<bool>> &fields,
               const std::tuple<Column_in<float>, Numbers, Numbers> &grids, const Rows_in<double, 3> &unit,
               const Numbers &which) {
    const auto &[frame, whitening, peak, patch_start] = lobes;
    const auto &[field_grid, field_weight, matrix, shift, as_bsdf] = fields;
    const Slices own{
        .scale = span(std::get<0>(slices)),
        .lobe_start = span(std::get<1>(slices)),
        .field_start = span(std::get<2>(slices)),
        .lobe_frame = {reinterpret_cast<const Vec *>(frame.data()), 3 * frame.shape(0)},
        .lobe_whitening = {whitening.data(), 4 * whitening.shape(0)},
        .lobe_peak = span(peak),
        .patch_start = span(patch_start),
        .patch_grid = span(std::get<0>(patches)),
        .patch_weight = span(std::get<1>(patches)),
        .field_grid = span(field_grid),
        .field_weight = span(field_weight),
        .field_matrix = {matrix.data(), 4 * matrix.shape(0)},
        .field_shift = {shift.data(), 2 * shift.shape(0)},
        .field_as_bsdf = span(as_bsdf),
    };
    const Grids read{span(std::get<0>(grids)), span(std::get<1>(grids)), span(std::get<2>(grids))};
    const std::size_t m = unit.shape(0);
    std::vector<double> found(m);
    {
        const nb::gil_scoped_release released;
        evaluate(own, read, {reinterpret_cast<const Vec *>(unit.data()), m}, span(which), found);
    }
    return taken<double, 1>(std::move(found), {m});
}

auto fitted(const Rows_in<double, 2> &position, const Floats &value, const Floats &variance, const Floats &weight,
            double half_width, std::size_t size) {
    std::vector<double> found;
    {
        const nb::gil_scoped_release released;
        found = fit_grid({places(position), span(value), span(variance), span(weight)}, half_width, size);
    }
    return taken<double, 2>(std::move(found), {size, size});
}

auto read_at(const Square_in &values, double half_width, const Rows_in<double, 2> &position) {
    const std::size_t size = values.shape(0);
    if (size < 2 || values.shape(1) != size) {
        throw std::invalid_argument("a grid has as many rows as columns, two at least");
    }
    const auto at = places(position);
    std::vector<double> found(at.size());
    {
        const nb::gil_scoped_release released;
        const double half = 0.5 * static_cast<double>(size - 1);
        sphere::in_threads(at.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                found[i] = bilinear(values.data(), static_cast<std::ptrdiff_t>(size),
                                    (at[i][0] / half_width + 1.0) * half, (at[i][1] / half_width + 1.0) * half);
            }
        });
    }
    return taken<double, 1>(std::move(found), {at.size()});
}

std::size_t size_for(const Rows_in<double, 2> &position, double half_width, std::size_t most_cells) {
    const nb::gil_scoped_release released;
    return suitable_size(places(position), half_width, most_cells);
}

auto near(const Rows_in<double, 3> &unit, const Rows_in<double, 3, 3> &frame, const Rows_in<double, 2, 2> &whitening,
          double reach) {
    Near found;
    {
        const nb::gil_scoped_release released;
        found = near_lobes({reinterpret_cast<const Vec *>(unit.data()), unit.shape(0)},
                           {reinterpret_cast<const Vec *>(frame.data()), 3 * frame.shape(0)},
                           {whitening.data(), 4 * whitening.shape(0)}, reach);
    }
    const std::size_t rows = found.row.size();
    const std::size_t starts = found.start.size();
    return std::tuple(taken<std::int64_t, 1>(std::move(found.start), {starts}),
                      taken<std::int64_t, 1>(std::move(found.row), {rows}),
                      taken<double, 2>(std::move(found.place), {rows, 2}));
}

auto sorted(const Rows_in<double, 3> &unit, const Floats &value, const Floats &variance, const Floats &weight,
            std::size_t size, std::size_t most) {
    Sorted_cells found;
    {
        const nb::gil_scoped_release released;
        const std::span<const Vec> towards{reinterpret_cast<const Vec *>(unit.data()), unit.shape(0)};
        found = sorted_cells({towards, span(value), span(variance), span(weight)}, size, most);
    }
    const std::size_t cells = found.home.size();
    const std::size_t rows = found.row.size();
    std::vector<double> sum;
    sum.reserve(6 * cells);
    for (const auto &one : found.sum) {
        sum.insert(sum.end(), one.begin(), one.end());
    }
    return std::tuple(taken<std::int64_t, 1>(std::move(found.home), {cells}),
                      taken<std::int64_t, 1>(std::move(found.start), {cells + 1}),
                      taken<std::int64_t, 1>(std::move(found.row), {rows}),
                      taken<double, 1>(std::move(found.weight), {rows}), taken<double, 2>(std::move(sum), {cells, 6}));
}

} // namespace
} // namespace gonio::model

NB_MODULE(_model, m) {
    m.def("evaluate", &gonio::model::evaluated, "slices"_a, "lobes"_a, "patches"_a, "fields"_a, "grids"_a, "unit"_a,
          "which"_a);
    m.def("fit_grid", &gonio::model::fitted, "position"_a, "value"_a, "variance"_a, "weight"_a, "half_width"_a,
          "size"_a);
    m.def("suitable_size", &gonio::model::size_for, "position"_a, "half_width"_a, "most_cells"_a);
    m.def("near_lobes", &gonio::model::near, "unit"_a, "frame"_a, "whitening"_a, "reach"_a);
    m.def("sorted_cells", &gonio::model::sorted, "unit"_a, "value"_a, "variance"_a, "weight"_a, "size"_a, "most"_a);
    m.def("grid_at", &gonio::model::read_at, "values"_a, "half_width"_a, "position"_a);
}
