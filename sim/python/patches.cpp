// patches.cpp: columns of a BSDF matrix, patch by patch, for Python.
#include <memory>
#include <string>
#include <vector>

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include "arrays.hpp"
#include "module_parts.hpp"
#include "patch_matrix.hpp"

namespace gonio::sim {
namespace {

namespace nb = nanobind;
using namespace nb::literals;
using Patches_in = nb::ndarray<const double, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;

std::vector<Patch> patches_of(const Patches_in &rows) {
    std::vector<Patch> patches(rows.shape(0));
    const double *next = rows.data();
    for (Patch &patch : patches) {
        patch = {next[0], next[1], next[2], next[3]};
        next += 4;
    }
    return patches;
}

nb::tuple as_tuple(Aperture_sums sums) {
    return nb::make_tuple(column(std::move(sums.weight)), column(std::move(sums.square)), column(std::move(sums.hits)));
}

// The scenario lives as long as the matrix.
class Python_matrix {
public:
    Python_matrix(std::shared_ptr<Photon_scenario> scenario, const std::string &band, const Patches_in &patches,
                  bool embree)
        : scenario_(std::move(scenario)),
          matrix_(*scenario_, band_of(*scenario_, band), patches_of(patches), embree ? Walk::embree : Walk::automatic) {
    }

    nb::tuple column_of(std::size_t patch, bool front_lit, std::uint64_t first, std::uint64_t count, unsigned threads,
                        Watch &watch) const {
        Patch_matrix::Column found = [&] {
            nb::gil_scoped_release const released;
            return matrix_.column(patch, front_lit, {first, count}, threads, watch);
        }();
        return nb::make_tuple(as_tuple(std::move(found.reflected)), as_tuple(std::move(found.transmitted)),
                              as_dict(found.balance));
    }

    [[nodiscard]] double depth_mm() const { return matrix_.depth_mm(); }

private:
    std::shared_ptr<Photon_scenario> scenario_;
    Patch_matrix matrix_;
};

} // namespace

void bind_patches(nb::module_ &module) {
    nb::class_<Python_matrix>(module, "PatchMatrix")
        .def(nb::init<std::shared_ptr<Photon_scenario>, const std::string &, const Patches_in &, bool>(), "scenario"_a,
             "band"_a, "patches_deg"_a, "embree"_a = false)
        .def_prop_ro("depth_mm", &Python_matrix::depth_mm)
        .def("column", &Python_matrix::column_of, "incident_patch"_a, "front_lit"_a, "first"_a, "count"_a, "threads"_a,
             "watch"_a);
}

} // namespace gonio::sim
