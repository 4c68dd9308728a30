// patch_matrix.cpp: a source that fills a patch, a receiver that counts patches.
#include "patch_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "elementary.hpp"
#include "make_scene.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr double turns_per_deg = 1.0 / 360.0;
constexpr double clear_of_sample_mm = 1e-3;
constexpr double far_mm = 1e9; // the receiver of directions alone

double cosine_of_deg(double angle_deg) {
    return sine_cosine_of_turns(angle_deg * turns_per_deg).cosine;
}

// Starts on a rectangle in the plane just before the lit side.
class Patch_source final : public Source {
public:
    Patch_source(const Patch &patch, double plane_z_mm, bool front_lit, double width_mm, double height_mm)
        : plane_z_mm_(plane_z_mm), side_(front_lit ? 1.0 : -1.0), width_mm_(width_mm), height_mm_(height_mm),
          phi_low_turns_(patch.phi_low_deg * turns_per_deg), phi_width_turns_(patch.phi_width_deg * turns_per_deg) {
        double const cosine_low = cosine_of_deg(patch.theta_low_deg);
        double const cosine_high = cosine_of_deg(patch.theta_high_deg);
        square_low_ = 1.0 - cosine_low * cosine_low;
        square_width_ = cosine_low * cosine_low - cosine_high * cosine_high;
    }

    [[nodiscard]] Start start(Photon_random &random) const override {
        double const x = (random.uniform() - 0.5) * width_mm_;
        double const y = (random.uniform() - 0.5) * height_mm_;
        // In proportion to the cosine: uniform in sin^2.
        double const square = square_low_ + random.uniform() * square_width_;
        Sine_cosine const phi = sine_cosine_of_turns(phi_low_turns_ + random.uniform() * phi_width_turns_);
        double const sine = std::sqrt(square);
        Vector const towards = {sine * phi.cosine, sine * phi.sine, side_ * std::sqrt(1.0 - square)};
        return {{x, y, plane_z_mm_}, -towards, {}, frame_about(towards).s};
    }

private:
    double plane_z_mm_;
    double side_;
    double width_mm_;
    double height_mm_;
    double phi_low_turns_;
    double phi_width_turns_;
    double square_low_;
    double square_width_;
};

// Finds the patch of a direction: rings of equal patches.
class Patch_finder {
public:
    explicit Patch_finder(std::span<const Patch> patches) {
        for (std::size_t i = 0; i < patches.size(); ++i) {
            const Patch &patch = patches[i];
            double const least_cosine = cosine_of_deg(patch.theta_high_deg);
            if (rings_.empty() || rings_.back().least_cosine != least_cosine) {
                rings_.push_back({least_cosine, patch.phi_low_deg * turns_per_deg, i, 0});
            }
            ++rings_.back().count;
        }
        rings_.back().least_cosine = 0.0;
    }

    [[nodiscard]] std::size_t find(const Vector &direction) const {
        double const cosine = std::abs(direction.z);
        auto ring =
            std::find_if(rings_.begin(), rings_.end(), [cosine](const Ring &r) { return cosine > r.least_cosine; });
        ring = ring == rings_.end() ? std::prev(ring) : ring; // exactly along the surface
        double turns = arc_tangent(direction.y, direction.x) * (0.5 / std::numbers::pi) - ring->phi_low_turns;
        turns -= std::floor(turns);
        auto const slot = static_cast<std::size_t>(turns * static_cast<double>(ring->count));
        return ring->first + std::min(slot, ring->count - 1);
    }

private:
    struct Ring {
        double least_cosine;
        double phi_low_turns;
        std::size_t first;
        std::size_t count;
    };
    std::vector<Ring> rings_;
};

class Patch_sink final : public Hit_sink {
public:
    Patch_sink(std::span<const Patch> patches, bool front_lit, unsigned workers)
        : finder_(patches), front_lit_(front_lit), reflected_(workers, Aperture_sums(patches.size())),
          transmitted_(workers, Aperture_sums(patches.size())) {}

    void take(std::span<const Receiver_hit> hits, unsigned worker) override {
        for (const Receiver_hit &hit : hits) {
            bool const same_side = (hit.direction.z > 0.0) == front_lit_;
            Aperture_sums &sums = same_side ? reflected_[worker] : transmitted_[worker];
            std::size_t const patch = finder_.find(hit.direction);
            sums.weight[patch] += hit.weight;
            sums.square[patch] += whole_square(hit.weight);
            ++sums.hits[patch];
        }
    }
    [[nodiscard]] Aperture_sums reflected() const { return total(reflected_); }
    [[nodiscard]] Aperture_sums transmitted() const { return total(transmitted_); }

private:
    static Aperture_sums total(const std::vector<Aperture_sums> &workers) {
        Aperture_sums sum = workers.front();
        std::for_each(workers.begin() + 1, workers.end(), [&sum](const Aperture_sums &other) { sum += other; });
        return sum;
    }

    Patch_finder finder_;
    bool front_lit_;
    std::vector<Aperture_sums> reflected_;
    std::vector<Aperture_sums> transmitted_;
};

} // namespace

Patch_matrix::Patch_matrix(const Photon_scenario &scenario, const Band &band, std::vector<Patch> patches, Walk walk)
    : trace_(scenario.trace), patches_(std::move(patches)), sample_(scenario.sample(band, true)),
      scene_(make_scene(sample_, walk)) {
    if (scenario.surround) {
        throw Input_error(scenario.path.string() +
                          ": rig: its parts stand in the way of light from all directions: leave them out");
    }
    trace_.receiver_radius_mm = far_mm;
}

Patch_matrix::Column Patch_matrix::column(std::size_t incident_patch, bool front_lit, const Photon_range &range,
                                          unsigned threads, Watch &watch) const {
    Box const box = sample_.shapes.bounds();
    double const plane_z_mm = front_lit ? box.high.z + clear_of_sample_mm : box.low.z - clear_of_sample_mm;
    Patch_source const source(patches_.at(incident_patch), plane_z_mm, front_lit, sample_.cell_width_mm,
                              sample_.cell_height_mm);
    Frame const axes = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    Patch_sink sink(patches_, front_lit, threads);
    Balance const balance = Tracer(*scene_, sample_.surfaces, source, axes, trace_).trace(range, threads, sink, watch);
    return {sink.reflected(), sink.transmitted(), balance};
}

double Patch_matrix::depth_mm() const {
    Box const box = sample_.shapes.bounds();
    return box.high.z - box.low.z;
}

} // namespace gonio::sim
