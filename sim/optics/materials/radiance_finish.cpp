// radiance_finish.cpp: rough finishes are Ward_duer with other parameters; smooth ones have a rise at grazing
// incidence.
#include "radiance_finish.hpp"

#include "elementary.hpp"
#include "hemisphere.hpp"
#include "two_way.hpp"
#include "ward_duer.hpp"

namespace gonio::sim {
namespace {

constexpr double fresnel_rate = 5.85;
constexpr double fresnel_offset = 0.00202943064;
constexpr double least_specularity_for_fresnel = 0.017999;
constexpr double least_roughness = 0.001; // its square is Radiance's FTINY

double fresnel_estimate(double cosine) {
    return exponential(-fresnel_rate * cosine) - fresnel_offset;
}

class Smooth_finish final : public Material {
public:
    // Specular part at normal incidence but for the rise, and diffuse part.
    Smooth_finish(double specular, double diffuse) : specular_(specular), diffuse_(diffuse) {}

    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random &random) const override {
        double const rise = fresnel_estimate(arrival.towards.z);
        double const specular = specular_ + rise * (1.0 - specular_);
        double const total = specular + diffuse_ * (1.0 - rise);
        double const mirror_part = specular / total;
        double const u = random.uniform();
        if (u < mirror_part) {
            return {mirrored(arrival.towards), total, {}};
        }
        Vector const direction = cosine_direction((u - mirror_part) / (1.0 - mirror_part), random.uniform());
        return {direction, total * (1.0 - fresnel_estimate(direction.z)), {}};
    }
    [[nodiscard]] double dsf_per_sr(const Arrival &arrival, const Vector &departing) const override {
        return departing.z > 0.0 ? diffuse_ * (1.0 - fresnel_estimate(arrival.towards.z)) *
                                       (1.0 - fresnel_estimate(departing.z)) * cosine_density_per_sr(departing)
                                 : 0.0;
    }
    [[nodiscard]] Albedo albedo(const Arrival &arrival) const override {
        constexpr double k = fresnel_rate;
        // Integral of 2 c (1 - F(c)) over c from 0 to 1.
        double const diffuse_kept = 1.0 + fresnel_offset - 2.0 * (1.0 - (1.0 + k) * exponential(-k)) / (k * k);
        double const rise = fresnel_estimate(arrival.towards.z);
        return {specular_ + rise * (1.0 - specular_) + diffuse_ * (1.0 - rise) * diffuse_kept, 0.0};
    }

private:
    double specular_;
    double diffuse_;
};

std::unique_ptr<Material> finish(double specular, double diffuse, double specularity, double roughness) {
    if (roughness <= least_roughness && specularity >= least_specularity_for_fresnel) {
        return std::make_unique<Smooth_finish>(specular, diffuse);
    }
    double const total = specular + diffuse;
    double const lobe = roughness > least_roughness ? roughness : 0.0;
    return std::make_unique<Ward_duer>(total, total > 0.0 ? specular / total : 0.0, lobe, lobe);
}

} // namespace

std::unique_ptr<Material> radiance_metal(double colour, double specularity, double roughness) {
    return finish(colour * specularity, colour * (1.0 - specularity), specularity, roughness);
}

std::unique_ptr<Material> radiance_plastic(double colour, double specularity, double roughness) {
    return finish(specularity, colour * (1.0 - specularity), specularity, roughness);
}

} // namespace gonio::sim
