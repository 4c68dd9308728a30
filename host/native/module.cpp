// module.cpp: the Python module _sphere: cells, triangles and fits of irregular directions, with numpy arrays in and
// out. Python's lock is released while they are made. What it offers is described in host/gonio/geometry/_sphere.pyi.
#include <algorithm>
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
#include <nanobind/stl/array.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>

#include "local_fit.hpp"
#include "locator.hpp"
#include "parts.hpp"
#include "tracks.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace gonio::sphere {
namespace {

using Vectors_in = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Column_in = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Numbers_in = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Flags_in = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <typename T> using Column = nb::ndarray<nb::numpy, T, nb::ndim<1>>;
template <typename T> using Table = nb::ndarray<nb::numpy, T, nb::ndim<2>>;

static_assert(sizeof(Vec) == 3 * sizeof(double));

std::span<const Vec> vectors(const Vectors_in &rows) {
    return {reinterpret_cast<const Vec *>(rows.data()), rows.shape(0)};
}

std::span<const double> values(const Column_in &column, std::size_t size) {
    if (column.shape(0) != size) {
        throw std::invalid_argument("one value per direction is needed");
    }
    return {column.data(), size};
}

// Arrays that take over a vector's memory.
template <typename T> nb::capsule owner_of(std::vector<T> &&held, T *&data) {
    auto owned = std::make_unique<std::vector<T>>(std::move(held));
    data = owned->data();
    return {owned.release(), [](void *one) noexcept { delete static_cast<std::vector<T> *>(one); }};
}

template <typename T> Column<T> column(std::vector<T> held) {
    const std::size_t size = held.size();
    T *data = nullptr;
    const nb::capsule owner = owner_of(std::move(held), data);
    return Column<T>(data, {size}, owner);
}

Table<double> table(std::vector<Vec> held) {
    const std::size_t size = held.size();
    Vec *data = nullptr;
    const nb::capsule owner = owner_of(std::move(held), data);
    return Table<double>(reinterpret_cast<double *>(data), {size, 3}, owner);
}

template <typename T> Table<T> table(std::vector<T> held, std::size_t width) {
    const std::size_t size = held.size() / width;
    T *data = nullptr;
    const nb::capsule owner = owner_of(std::move(held), data);
    return Table<T>(data, {size, width}, owner);
}

Reach reach_in(const Column_in &reach, const Flags_in &shared, std::size_t size) {
    if (shared.shape(0) != size && shared.shape(0) != 0) {
        throw std::invalid_argument("one flag per direction, or none, is needed");
    }
    return {values(reach, size), {shared.data(), shared.shape(0)}};
}

auto cells(const Vectors_in &unit, const Column_in &reach, const Flags_in &shared, bool cut_at_horizon) {
    const auto points = vectors(unit);
    const Reach limits = reach_in(reach, shared, points.size());
    Cells found;
    {
        const nb::gil_scoped_release released;
        found = cells_of_points(points, limits, cut_at_horizon);
    }
    return std::tuple(column(std::move(found.solid)), column(std::move(found.linear)), table(std::move(found.moment)));
}

auto edges(const Vectors_in &unit) {
    const auto points = vectors(unit);
    std::vector<std::int64_t> found;
    std::vector<std::int64_t> stands_for(points.size());
    {
        const nb::gil_scoped_release released;
        for_each_part(points, false, [&](const Part_of_sphere &part) {
            found = edges_of(part);
            for (std::size_t i = 0; i < part.points.size(); ++i) {
                stands_for[part.number[i]] = part.number[part.stands_for[i]];
            }
        });
    }
    return std::tuple(table(std::move(found), 2), column(std::move(stands_for)));
}

auto distances(const Vectors_in &unit, const Vectors_in &ahead, const Column_in &length, const Numbers_in &path,
               const std::array<double, 4> &rules) {
    const auto points = vectors(unit);
    if (ahead.shape(0) != points.size() || path.shape(0) != points.size()) {
        throw std::invalid_argument("one tangent and one path per direction is needed");
    }
    const Track track{points, vectors(ahead), values(length, points.size()), {path.data(), points.size()}};
    std::vector<double> found;
    {
        const nb::gil_scoped_release released;
        found.reserve(3 * points.size());
        for (const Beside &one : track_distances(track, {rules[0], rules[1], rules[2], rules[3]})) {
            found.insert(found.end(), {one.near, one.far, one.way});
        }
    }
    return table(std::move(found), 3);
}

auto reach_shared(const Vectors_in &unit, const Column_in &reach, const Flags_in &shared) {
    const auto points = vectors(unit);
    const Reach own = reach_in(reach, shared, points.size());
    std::vector<double> found;
    {
        const nb::gil_scoped_release released;
        found = shared_reach(points, own);
    }
    return column(std::move(found));
}

auto fits(const Vectors_in &unit, const Column_in &value, const Column_in &variance, const Flags_in &used,
          double radius) {
    const auto points = vectors(unit);
    const std::size_t n = points.size();
    const auto own_values = values(value, n);
    const auto own_variances = values(variance, n);
    if (used.shape(0) != n) {
        throw std::invalid_argument("one flag per direction is needed");
    }
    std::vector<double> fitted(n);
    std::vector<Vec> gradient(n);
    std::vector<double> hessian(6 * n);
    std::vector<double> gradient_variance(n);
    {
        const nb::gil_scoped_release released;
        std::vector<Cluster> samples;
        samples.reserve(n);
        for (std::size_t i = 0; i < n; ++i) {
            if (used.data()[i]) {
                samples.push_back(cluster_of(points[i], own_values[i], own_variances[i]));
            }
        }
        const std::vector<Fit> found = local_fits(points, samples, radius);
        for (std::size_t i = 0; i < n; ++i) {
            fitted[i] = found[i].value;
            gradient[i] = found[i].gradient;
            std::copy(found[i].hessian.begin(), found[i].hessian.end(), hessian.begin() + static_cast<long>(6 * i));
            gradient_variance[i] = found[i].gradient_variance;
        }
    }
    return std::tuple(column(std::move(fitted)), table(std::move(gradient)), table(std::move(hessian), 6),
                      column(std::move(gradient_variance)));
}

std::unique_ptr<Locator> locator(const Vectors_in &unit, const Column_in &reach, bool cut_at_horizon) {
    const auto points = vectors(unit);
    const auto limits = values(reach, points.size());
    const nb::gil_scoped_release released;
    return std::make_unique<Locator>(points, limits, cut_at_horizon);
}

auto located(const Locator &self, const Vectors_in &directions) {
    const auto wanted = vectors(directions);
    const std::size_t m = wanted.size();
    std::vector<std::int64_t> index(3 * m);
    std::vector<double> weight(3 * m);
    auto inside = std::make_unique<bool[]>(m);
    {
        const nb::gil_scoped_release released;
        const std::vector<Found> found = self.at(wanted);
        for (std::size_t i = 0; i < m; ++i) {
            std::copy(found[i].index.begin(), found[i].index.end(), index.begin() + static_cast<long>(3 * i));
            std::copy(found[i].weight.begin(), found[i].weight.end(), weight.begin() + static_cast<long>(3 * i));
            inside[i] = found[i].inside;
        }
    }
    bool *const data = inside.get();
    const nb::capsule owner(inside.release(), [](void *one) noexcept { delete[] static_cast<bool *>(one); });
    return std::tuple(table(std::move(index), 3), table(std::move(weight), 3), Column<bool>(data, {m}, owner));
}

} // namespace
} // namespace gonio::sphere

NB_MODULE(_sphere, m) {
    m.def("cells", &gonio::sphere::cells, "unit"_a, "reach"_a, "shared"_a, "cut_at_horizon"_a);
    m.def("edges", &gonio::sphere::edges, "unit"_a);
    m.def("track_distances", &gonio::sphere::distances, "unit"_a, "ahead"_a, "length"_a, "path"_a, "rules"_a);
    m.def("shared_reach", &gonio::sphere::reach_shared, "unit"_a, "reach"_a, "shared"_a);
    m.def("local_fit", &gonio::sphere::fits, "unit"_a, "values"_a, "variance"_a, "used"_a, "radius"_a);
    nb::class_<gonio::sphere::Locator>(m, "Locator")
        .def(nb::new_(&gonio::sphere::locator), "unit"_a, "reach"_a, "cut_at_horizon"_a)
        .def("at", &gonio::sphere::located, "directions"_a);
}
