// arrays.hpp: between numpy arrays and the photon map's vectors: a result's array takes over the vector's memory.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "estimate.hpp"
#include "vector.hpp"

namespace gonio::sim {

// What a caller hands in: numpy converts other types and strides.
using Vectors_in = nanobind::ndarray<const double, nanobind::shape<-1, 3>, nanobind::c_contig, nanobind::device::cpu>;
using Counts_in = nanobind::ndarray<const std::uint64_t, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;
using Table_in = nanobind::ndarray<const double, nanobind::ndim<2>, nanobind::c_contig, nanobind::device::cpu>;

template <typename T> using Column = nanobind::ndarray<nanobind::numpy, T, nanobind::ndim<1>>;

// An array (n,) that owns the values.
template <typename T> Column<T> column(std::vector<T> values) {
    auto owned = std::make_unique<std::vector<T>>(std::move(values));
    T *const data = owned->data();
    std::size_t const size = owned->size();
    nanobind::capsule const owner(owned.release(),
                                  [](void *held) noexcept { delete static_cast<std::vector<T> *>(held); });
    return Column<T>(data, {size}, owner);
}

inline std::vector<Vector> vectors(const Vectors_in &rows) {
    std::vector<Vector> result(rows.shape(0));
    const double *next = rows.data();
    for (Vector &vector : result) {
        vector = {next[0], next[1], next[2]};
        next += 3;
    }
    return result;
}

// DSF, its standard error, half angle, hits: four arrays (n,).
using Estimate_columns = std::tuple<Column<double>, Column<double>, Column<double>, Column<std::uint64_t>>;

inline Estimate_columns columns(std::span<const Estimate> estimates) {
    std::vector<double> dsf;
    std::vector<double> error;
    std::vector<double> half_angle;
    std::vector<std::uint64_t> hits;
    for (const Estimate &one : estimates) {
        dsf.push_back(one.dsf_per_sr);
        error.push_back(one.standard_error_per_sr);
        half_angle.push_back(one.half_angle_rad);
        hits.push_back(one.hits);
    }
    return {column(std::move(dsf)), column(std::move(error)), column(std::move(half_angle)), column(std::move(hits))};
}

} // namespace gonio::sim
