// ward_duer.cpp: the first of two random numbers also chooses between lobe and diffuse part.
#include "ward_duer.hpp"

#include "hemisphere.hpp"
#include "two_way.hpp"

namespace gonio::sim {

Ward_duer::Ward_duer(double reflectance, double specular_share, double roughness_x, double roughness_y)
    : reflectance_(reflectance), specular_share_(specular_share) {
    if (roughness_x > 0.0) {
        lobe_.emplace(roughness_x, roughness_y);
    }
}

Departure Ward_duer::scatter(const Arrival &arrival, Photon_random &random) const {
    if (!lobe_ && specular_share_ >= 1.0) {
        return {mirrored(arrival.towards), reflectance_, {}};
    }
    double const u = random.uniform();
    if (u >= specular_share_) {
        return {cosine_direction((u - specular_share_) / (1.0 - specular_share_), random.uniform()), reflectance_, {}};
    }
    if (!lobe_) {
        return {mirrored(arrival.towards), reflectance_, {}};
    }
    Ward_lobe::Drawn const drawn = lobe_->draw(arrival.towards, u / specular_share_, random.uniform());
    return {drawn.direction, reflectance_ * drawn.weight, {}};
}

double Ward_duer::dsf_per_sr(const Arrival &arrival, const Vector &departing) const {
    if (!(departing.z > 0.0)) {
        return 0.0;
    }
    double const lobe = lobe_ ? lobe_->dsf_per_sr(arrival.towards, departing) : 0.0;
    return reflectance_ * (specular_share_ * lobe + (1.0 - specular_share_) * cosine_density_per_sr(departing));
}

Albedo Ward_duer::albedo(const Arrival &arrival) const {
    double const lobe = lobe_ ? lobe_->albedo(arrival.towards) : 1.0;
    return {reflectance_ * (specular_share_ * lobe + 1.0 - specular_share_), 0.0};
}

} // namespace gonio::sim
