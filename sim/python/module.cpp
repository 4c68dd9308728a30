// module.cpp: the Python module _photons: scenarios, the virtual goniophotometer and stored maps, with numpy arrays in
// and out. Python's lock is released while photons fly. What it offers is described in
// host/gonio/simulate/_photons.pyi.
#include <memory>
#include <optional>
#include <string>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "hit_map.hpp"
#include "module_parts.hpp"
#include "photon_scenario.hpp"
#include "progressive.hpp"
#include "rig_scenario.hpp"
#include "toml_table.hpp"
#include "virtual_goniophotometer.hpp"

namespace gonio::sim {

namespace nb = nanobind;
using namespace nb::literals;

const Band &band_of(const Photon_scenario &scenario, const std::string &name) {
    for (const Band &band : scenario.bands) {
        if (band.name == name) {
            return band;
        }
    }
    throw Input_error(scenario.path.string() + ": there is no band \"" + name + "\"; add a [[band]] of that name");
}

nb::dict as_dict(const Balance &balance) {
    nb::dict result;
    result["photons"] = balance.photons;
    result["emitted"] = balance.emitted;
    result["stored"] = balance.stored;
    result["stored_front"] = balance.stored_front;
    result["front_square"] = balance.front_square;
    result["back_square"] = balance.back_square;
    result["absorbed"] = balance.absorbed;
    result["lost"] = balance.lost;
    result["roulette"] = balance.roulette;
    return result;
}

namespace {

// Python's Scatter_table: distributions are added one by one.
class Python_table {
public:
    Python_table(std::uint32_t cells, const std::string &follow, bool isotropic) {
        table_.cells = cells;
        table_.isotropic = isotropic;
        if (follow == "mirror") {
            table_.follow = Scatter_table::Follow::mirror;
        } else if (follow == "retro") {
            table_.follow = Scatter_table::Follow::retro;
        } else if (follow == "through") {
            table_.follow = Scatter_table::Follow::through;
        } else if (follow != "none") {
            throw Input_error("follow = \"" + follow + "\": none, mirror, retro or through expected");
        }
    }
    void add(bool back, double theta_deg, double phi_deg, const std::optional<Table_in> &reflected,
             const std::optional<Table_in> &transmitted) {
        Scatter_table::Distribution distribution{theta_deg, phi_deg, cells_of(reflected), cells_of(transmitted)};
        (back ? table_.back : table_.front).push_back(std::move(distribution));
    }
    [[nodiscard]] const Scatter_table &table() const { return table_; }

private:
    [[nodiscard]] std::vector<double> cells_of(const std::optional<Table_in> &values) const {
        if (!values) {
            return {};
        }
        if (values->shape(0) != table_.cells || values->shape(1) != table_.cells) {
            throw nb::value_error("the values must have the shape (cells, cells)");
        }
        return {values->data(), values->data() + values->size()};
    }

    Scatter_table table_;
};

std::shared_ptr<Photon_scenario> load(const std::string &path, const std::string &source_directory,
                                      const std::map<std::string, Python_table> &tables,
                                      std::optional<std::uint64_t> seed) {
    std::map<std::string, Scatter_table> read;
    for (const auto &[name, table] : tables) {
        read.emplace(name, table.table());
    }
    auto scenario = std::make_shared<Photon_scenario>(load_rig_scenario(path, source_directory, read));
    scenario->trace.seed = seed.value_or(scenario->trace.seed);
    return scenario;
}

// The scenario lives as long as what was built from it.
class Python_goniophotometer {
public:
    Python_goniophotometer(std::shared_ptr<Photon_scenario> scenario, const std::string &band, double theta_deg,
                           double phi_deg, bool mounted, bool embree)
        : scenario_(std::move(scenario)), goniophotometer_(*scenario_, band_of(*scenario_, band), {theta_deg, phi_deg},
                                                           mounted, embree ? Walk::embree : Walk::automatic) {}

    [[nodiscard]] double aperture_half_angle_rad() const { return goniophotometer_.aperture_half_angle_rad(); }

    nb::tuple read(const Vectors_in &directions, double half_angle_rad, std::uint64_t first, std::uint64_t count,
                   unsigned threads, Watch &watch) const {
        std::vector<Vector> const to = vectors(directions);
        Virtual_goniophotometer::Sums sums = [&] {
            nb::gil_scoped_release const released;
            return goniophotometer_.read(to, half_angle_rad, {first, count}, threads, watch);
        }();
        return nb::make_tuple(column(std::move(sums.apertures.weight)), column(std::move(sums.apertures.square)),
                              column(std::move(sums.apertures.hits)), as_dict(sums.balance));
    }
    nb::tuple store(std::uint64_t first, std::uint64_t count, unsigned threads, Watch &watch) const {
        Virtual_goniophotometer::Stored stored = [&] {
            nb::gil_scoped_release const released;
            return goniophotometer_.store({first, count}, threads, watch);
        }();
        return nb::make_tuple(std::make_shared<Hit_map>(std::move(stored.map)), as_dict(stored.balance));
    }

private:
    std::shared_ptr<Photon_scenario> scenario_;
    Virtual_goniophotometer goniophotometer_;
};

// Estimates at directions, found by `read` while Python goes on.
template <typename Read> Estimate_columns estimates(const Vectors_in &directions, Read read) {
    std::vector<Vector> const to = vectors(directions);
    std::vector<Estimate> const found = [&] {
        nb::gil_scoped_release const released;
        return read(to);
    }();
    return columns(found);
}

Aperture_sums sums_of(const Counts_in &weight, const Counts_in &square, const Counts_in &hits) {
    if (square.size() != weight.size() || hits.size() != weight.size()) {
        throw nb::value_error("weight, square and hits must have the same shape (n,)");
    }
    Aperture_sums sums;
    sums.weight.assign(weight.data(), weight.data() + weight.size());
    sums.square.assign(square.data(), square.data() + square.size());
    sums.hits.assign(hits.data(), hits.data() + hits.size());
    return sums;
}

Estimate_columns estimates_of(const Counts_in &weight, const Counts_in &square, const Counts_in &hits,
                              std::uint64_t photons, double half_angle_rad) {
    Aperture_sums const sums = sums_of(weight, square, hits);
    std::vector<Estimate> found;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        found.push_back(estimate(sums.weight[i], sums.square[i], sums.hits[i], photons, half_angle_rad));
    }
    return columns(found);
}

std::tuple<double, std::uint64_t, std::uint64_t> precision_of(const Counts_in &weight, const Counts_in &square,
                                                              const Counts_in &hits, std::uint64_t photons,
                                                              double relative_error) {
    Precision const found = precision(sums_of(weight, square, hits), photons, relative_error);
    return {found.median_relative_error, found.lit, found.further_photons};
}

// What the user gave wrong is one line for the user in Python too.
void translate_input_error(const std::exception_ptr &thrown, void * /*unused*/) {
    try {
        std::rethrow_exception(thrown);
    } catch (const Input_error &error) {
        nb::object const kind = nb::module_::import_("gonio.units.errors").attr("UsageError");
        PyErr_SetString(kind.ptr(), error.what());
    }
}

void bind_scenario(nb::module_ &module) {
    nb::class_<Python_table>(module, "ScatterTable")
        .def(nb::init<std::uint32_t, const std::string &, bool>(), "cells"_a, "follow"_a, "isotropic"_a)
        .def("add", &Python_table::add, "back"_a, "theta_deg"_a, "phi_deg"_a, "reflected"_a.none(),
             "transmitted"_a.none());
    nb::class_<Photon_scenario>(module, "Scenario")
        .def(nb::new_(&load), "path"_a, "source_directory"_a, "tables"_a, "seed"_a.none() = nb::none())
        .def_prop_ro("bands",
                     [](const Photon_scenario &scenario) {
                         std::vector<std::pair<std::string, double>> bands;
                         for (const Band &band : scenario.bands) {
                             bands.emplace_back(band.name, band.wavelength_nm);
                         }
                         return bands;
                     })
        .def_prop_ro("incidents",
                     [](const Photon_scenario &scenario) {
                         std::vector<std::pair<double, double>> incidents;
                         for (const Incident &incident : scenario.incidents) {
                             incidents.emplace_back(incident.theta_deg, incident.phi_deg);
                         }
                         return incidents;
                     })
        .def(
            "walk",
            [](const Photon_scenario &scenario, const std::string &band) {
                return scenario.sample(band_of(scenario, band), true).slats ? "slats" : "embree";
            },
            "band"_a)
        .def_ro("photons", &Photon_scenario::photons)
        .def_ro("relative_error", &Photon_scenario::relative_error)
        .def_ro("most_photons", &Photon_scenario::most_photons)
        .def_ro("direction_step_deg", &Photon_scenario::direction_step_deg)
        .def_prop_ro("seed", [](const Photon_scenario &scenario) { return scenario.trace.seed; })
        .def_prop_ro("radius_mm", [](const Photon_scenario &scenario) { return scenario.receiver.radius_mm; })
        .def_prop_ro("aperture_mm", [](const Photon_scenario &scenario) { return scenario.receiver.aperture_mm; })
        .def_prop_ro("acceptance_deg", [](const Photon_scenario &scenario) { return scenario.receiver.acceptance_deg; })
        .def_prop_ro("estimator",
                     [](const Photon_scenario &scenario) {
                         switch (scenario.receiver.estimator) {
                         case Estimator::nearest:
                             return "nearest";
                         case Estimator::progressive:
                             return "progressive";
                         case Estimator::fixed:
                             break;
                         }
                         return "fixed";
                     })
        .def_prop_ro("bandwidth", [](const Photon_scenario &scenario) { return scenario.receiver.bandwidth; });
}

void bind_tracing(nb::module_ &module) {
    nb::class_<Watch>(module, "Watch")
        .def(nb::init<>())
        .def_prop_ro("photons", [](const Watch &watch) { return watch.photons.load(); })
        .def_prop_ro("cancelled", [](const Watch &watch) { return watch.cancelled.load(); })
        .def("cancel", [](Watch &watch) { watch.cancelled.store(true); });
    nb::class_<Hit_map>(module, "HitMap")
        .def_prop_ro("bytes", &Hit_map::bytes)
        .def(
            "fixed",
            [](const Hit_map &map, const Vectors_in &directions, double half_angle_rad, unsigned threads) {
                return estimates(directions, [&](const auto &to) { return map.fixed(to, half_angle_rad, threads); });
            },
            "directions"_a, "half_angle_rad"_a, "threads"_a)
        .def(
            "nearest",
            [](const Hit_map &map, const Vectors_in &directions, std::uint32_t bandwidth, double most_rad,
               unsigned threads) {
                return estimates(directions,
                                 [&](const auto &to) { return map.nearest(to, bandwidth, most_rad, threads); });
            },
            "directions"_a, "bandwidth"_a, "most_half_angle_rad"_a, "threads"_a);
    nb::class_<Progressive_readings>(module, "ProgressiveReadings")
        .def(nb::new_([](const Vectors_in &directions, double first_rad) {
                 return std::make_unique<Progressive_readings>(vectors(directions), first_rad);
             }),
             "directions"_a, "first_half_angle_rad"_a)
        .def("add", &Progressive_readings::add, "batch"_a, "threads"_a, nb::call_guard<nb::gil_scoped_release>())
        .def("estimates", [](const Progressive_readings &readings) { return columns(readings.estimates()); });
    nb::class_<Python_goniophotometer>(module, "Goniophotometer")
        .def(nb::init<std::shared_ptr<Photon_scenario>, const std::string &, double, double, bool, bool>(),
             "scenario"_a, "band"_a, "theta_i_deg"_a, "phi_i_deg"_a, "mounted"_a = true, "embree"_a = false)
        .def_prop_ro("aperture_half_angle_rad", &Python_goniophotometer::aperture_half_angle_rad)
        .def("read", &Python_goniophotometer::read, "directions"_a, "half_angle_rad"_a, "first"_a, "count"_a,
             "threads"_a, "watch"_a)
        .def("store", &Python_goniophotometer::store, "first"_a, "count"_a, "threads"_a, "watch"_a);
    module.def("estimate", &estimates_of, "weight"_a, "square"_a, "hits"_a, "photons"_a, "half_angle_rad"_a);
    module.def("precision", &precision_of, "weight"_a, "square"_a, "hits"_a, "photons"_a, "relative_error"_a);
}

} // namespace
} // namespace gonio::sim

NB_MODULE(_photons, module) {
    module.attr("embree") = GONIO_EMBREE_VERSION;
    nanobind::register_exception_translator(gonio::sim::translate_input_error);
    gonio::sim::bind_scenario(module);
    gonio::sim::bind_tracing(module);
    gonio::sim::bind_patches(module);
}
