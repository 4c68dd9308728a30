// photon_scenario.hpp: a scenario file as the photon map needs it: sample, beam, source, receiver, rig, what to read.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sample.hpp"
#include "source.hpp"
#include "tabulated.hpp"
#include "tracer.hpp"

namespace gonio::sim {

struct Band {
    std::string name;     // the dataset's channel: "visible", "near-infrared", ...
    double wavelength_nm; // at which indices of refraction are taken
};

struct Incident {
    double theta_deg;
    double phi_deg;
};

enum class Estimator {
    fixed,       // the detector's own aperture: unbiased
    nearest,     // the cap that holds the nearest `bandwidth` hits
    progressive, // apertures that shrink as photons come in
};

// What of the instrument the photons see, and how their map is read.
struct Receiver_settings {
    double radius_mm = 1020.0;
    double aperture_mm = 10.0;
    double acceptance_deg = 180.0; // half angle of the detector's field of view
    Estimator estimator = Estimator::fixed;
    std::uint32_t bandwidth = 50; // hits, of nearest
};

struct Photon_scenario {
    std::filesystem::path path;
    Trace_settings trace;
    std::uint64_t photons = 1000000; // per incident direction and band, unless an error is asked for
    double relative_error = 0.0;     // > 0: photons until the median reading is this good
    std::uint64_t most_photons = 0;  // where that ends
    std::vector<Band> bands;
    std::vector<Incident> incidents;
    double direction_step_deg = 1.0; // of the grid that is read where no measurement is followed
    Receiver_settings receiver;

    // Built anew per band. `mounted` false: the free beam; sample and holder are out of it.
    std::function<Sample_model(const Band &band, bool mounted)> sample;
    std::function<std::unique_ptr<Source>(const Band &band)> source;
    // What stands around the sample, fixed in the lab (rig/); empty: nothing does. `model` is what sample() gave,
    // `lab_axes` the lab's axes in the sample frame.
    std::function<std::unique_ptr<Scene>(const Sample_model &model, std::unique_ptr<Scene> sample,
                                         const Frame &lab_axes)>
        surround;
};

// `tables`: data-driven BSDF that the caller has read, by the file name in the scenario; others are looked for as text
// tables beside the scenario. Strict; every band's sample is built once, to say what is wrong now. Throws Input_error.
Photon_scenario load_photon_scenario(const std::filesystem::path &path, const std::filesystem::path &source_directory,
                                     const std::map<std::string, Scatter_table> &tables);

} // namespace gonio::sim
