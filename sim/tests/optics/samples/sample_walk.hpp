// sample_walk.hpp: a sample from the text of a scenario, and a plain walk of light through it: no roulette, no threads,
// no whole numbers: independent of the tracer.
#pragma once

#include <cmath>
#include <numbers>
#include <string>

#include "embree_scene.hpp"
#include "sample_reader.hpp"

namespace gonio::sim {

inline constexpr double deg = std::numbers::pi / 180.0;

// Towards a direction of the sample frame.
inline Vector towards(double theta_deg, double phi_deg) {
    double const theta = theta_deg * deg;
    double const phi = phi_deg * deg;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

struct Light {
    Vector place;
    Vector direction; // of travel, away from the sample
    double weight;
    int interactions;
};

class Sample_walk {
public:
    explicit Sample_walk(const std::string &scenario, const std::string &band = "visible", double wavelength_nm = 550.0)
        : root_(toml::parse(scenario)), sample_(read_sample(root_, "test.toml", {band, wavelength_nm, tables_, "."})),
          scene_(make_embree_scene(sample_.shapes)) {}

    [[nodiscard]] const Sample_model &sample() const { return sample_; }
    [[nodiscard]] const Scene &scene() const { return *scene_; }

    // A ray of light from `from` that passes the front's plane at (x, y).
    [[nodiscard]] static Ray ray_to(double x, double y, const Vector &from) {
        return {Vector{x, y, 0.0} + 500.0 * from, -from};
    }
    [[nodiscard]] bool passes(const Ray &ray) const {
        Hit hit{};
        return !scene_->closest(ray, hit);
    }

    [[nodiscard]] Light follow(Ray ray, Photon_random &random) const {
        Light light{ray.origin, ray.direction, 1.0, 0};
        double absorption_per_mm = 0.0;
        Hit hit{};
        while (light.weight > 0.0 && light.interactions < 100000 && scene_->closest(ray, hit)) {
            ++light.interactions;
            light.weight *= std::exp(-absorption_per_mm * hit.distance_mm);
            const Surface &surface = sample_.surfaces.at(hit.surface);
            bool const from_front = dot(ray.direction, hit.normal) < 0.0;
            Vector const normal = from_front ? hit.normal : -hit.normal;
            Frame const axes{hit.tangent, cross(normal, hit.tangent), normal};
            const Material &material = from_front ? *surface.front : *surface.back;
            Departure const departure = material.scatter({axes.to_local(-ray.direction), from_front, {}}, random);
            light.weight *= departure.share;
            bool const through = departure.direction.z < 0.0;
            absorption_per_mm =
                from_front != through ? surface.front_absorption_per_mm : surface.back_absorption_per_mm;
            ray = {ray.origin + hit.distance_mm * ray.direction, unit(axes.to_world(departure.direction)),
                   hit.primitive};
        }
        light.place = ray.origin;
        light.direction = ray.direction;
        return light;
    }

private:
    std::map<std::string, Scatter_table> tables_;
    toml::table root_;
    Sample_model sample_;
    std::unique_ptr<Scene> scene_;
};

// Share of light at (theta, phi) that passes without touching anything, over one cell of the sample about the middle.
inline double direct_transmittance(const Sample_walk &walk, double theta_deg, double phi_deg, int columns, int rows) {
    int passed = 0;
    Vector const from = towards(theta_deg, phi_deg);
    double const width = walk.sample().cell_width_mm;
    double const height = walk.sample().cell_height_mm;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            double const x = ((column + 0.5) / columns - 0.5) * width;
            double const y = ((row + 0.5) / rows - 0.5) * height;
            passed += walk.passes(Sample_walk::ray_to(x, y, from)) ? 1 : 0;
        }
    }
    return static_cast<double>(passed) / (rows * columns);
}

// Means over light that falls evenly on one cell.
struct Sums {
    double transmitted = 0.0;
    double transmitted_up = 0.0; // of it, with direction.y > 0
    double reflected = 0.0;
};

template <class Visit> void shine(const Sample_walk &walk, const Vector &from, int photons, const Visit &visit) {
    for (int photon = 0; photon < photons; ++photon) {
        Photon_random random(20240607, static_cast<std::uint64_t>(photon));
        double const x = (random.uniform() - 0.5) * walk.sample().cell_width_mm;
        double const y = (random.uniform() - 0.5) * walk.sample().cell_height_mm;
        visit(walk.follow(Sample_walk::ray_to(x, y, from), random));
    }
}

inline Sums sums(const Sample_walk &walk, double theta_deg, double phi_deg, int photons) {
    Sums sums{};
    shine(walk, towards(theta_deg, phi_deg), photons, [&](const Light &light) {
        double const share = light.weight / photons;
        (light.direction.z < 0.0 ? sums.transmitted : sums.reflected) += share;
        if (light.direction.z < 0.0 && light.direction.y > 0.0) {
            sums.transmitted_up += share;
        }
    });
    return sums;
}

} // namespace gonio::sim
