// ggx_dielectric.cpp: a facet is drawn among those that the light sees, Fresnel chooses, the way out shades.
#include "ggx_dielectric.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "elementary.hpp"
#include "fresnel.hpp"

namespace gonio::sim {

Ggx_dielectric::Ggx_dielectric(double alpha_x, double alpha_y, double inside_index, double outside_index,
                               double inside_absorption_per_mm)
    : alpha_x_(alpha_x), alpha_y_(alpha_y), ratio_from_front_(inside_index / outside_index),
      ratio_from_back_(outside_index / inside_index), inside_absorption_per_mm_(inside_absorption_per_mm) {}

// Heitz (2018), "Sampling the GGX distribution of visible normals", listing 1.
Vector Ggx_dielectric::visible_normal(const Vector &towards, double u, double v) const {
    Vector const stretched = unit({alpha_x_ * towards.x, alpha_y_ * towards.y, towards.z});
    double const square = stretched.x * stretched.x + stretched.y * stretched.y;
    Vector first{1.0, 0.0, 0.0};
    if (square > 0.0) {
        double const scale = 1.0 / std::sqrt(square);
        first = {-stretched.y * scale, stretched.x * scale, 0.0};
    }
    Vector const second = cross(stretched, first);
    double const radius = std::sqrt(u);
    Sine_cosine const azimuth = sine_cosine_of_turns(v);
    double const a = radius * azimuth.cosine;
    double const half = 0.5 * (1.0 + stretched.z);
    double const b = (1.0 - half) * std::sqrt(std::max(0.0, 1.0 - a * a)) + half * radius * azimuth.sine;
    Vector const normal = a * first + b * second + std::sqrt(std::max(0.0, 1.0 - a * a - b * b)) * stretched;
    return unit({alpha_x_ * normal.x, alpha_y_ * normal.y, std::max(0x1p-40, normal.z)});
}

double Ggx_dielectric::unshaded(const Vector &direction) const {
    double const x = alpha_x_ * direction.x;
    double const y = alpha_y_ * direction.y;
    return 2.0 / (1.0 + std::sqrt(1.0 + (x * x + y * y) / (direction.z * direction.z)));
}

Departure Ggx_dielectric::scatter(const Arrival &arrival, Photon_random &random) const {
    double const u = random.uniform();
    double const v = random.uniform();
    Vector const normal = visible_normal(arrival.towards, u, v);
    double const cosine = dot(arrival.towards, normal);
    double const ratio = arrival.from_front ? ratio_from_front_ : ratio_from_back_;
    Refraction const refraction = refract(cosine, ratio);
    bool const reflects = random.uniform() < unpolarised(refraction.powers).reflectance;
    Vector const direction = reflects ? 2.0 * cosine * normal - arrival.towards
                                      : refracted(arrival.towards, normal, cosine, refraction.cosine, ratio);
    bool const leaves = reflects ? direction.z > 0.0 : direction.z < 0.0;
    return {direction, leaves ? unshaded(direction) : 0.0, {}};
}

// Walter et al. (2007), eqs. 20 and 21 with separable shading; density of visible normals: Heitz (2018), eq. 3.
double Ggx_dielectric::dsf_per_sr(const Arrival &arrival, const Vector &departing) const {
    Vector const &towards = arrival.towards;
    double const ratio = arrival.from_front ? ratio_from_front_ : ratio_from_back_;
    bool const reflects = departing.z > 0.0;
    Vector normal = unit(reflects ? towards + departing : towards + ratio * departing);
    if (normal.z < 0.0) {
        normal = -normal;
    }
    double const in = dot(towards, normal);
    double const out = dot(departing, normal);
    if (departing.z == 0.0 || !(in > 0.0) || (out > 0.0) != reflects) {
        return 0.0;
    }
    double const x = normal.x / alpha_x_;
    double const y = normal.y / alpha_y_;
    double const steep = x * x + y * y + normal.z * normal.z;
    double const visible =
        unshaded(towards) * in / (towards.z * std::numbers::pi * alpha_x_ * alpha_y_ * steep * steep);
    Albedo const facet = unpolarised(refract(in, ratio).powers);
    double const spread = in + ratio * out;
    double const facets_per_sr =
        reflects ? facet.reflectance / (4.0 * in) : facet.transmittance * ratio * ratio * -out / (spread * spread);
    return visible * facets_per_sr * unshaded(departing);
}

Albedo Ggx_dielectric::albedo(const Arrival &arrival) const {
    constexpr int steps = 384;
    double const ratio = arrival.from_front ? ratio_from_front_ : ratio_from_back_;
    Albedo sum{0.0, 0.0};
    for (int row = 0; row < steps; ++row) {
        double const turns = (row + 0.5) / steps;
        for (int column = 0; column < steps; ++column) {
            // Steps crowd at both ends: at the rim the facets are steep.
            double const s = (column + 0.5) / steps;
            double const weight = 6.0 * s * (1.0 - s);
            Vector const normal = visible_normal(arrival.towards, s * s * (3.0 - 2.0 * s), turns);
            double const cosine = dot(arrival.towards, normal);
            Refraction const refraction = refract(cosine, ratio);
            Albedo const facet = unpolarised(refraction.powers);
            Vector const back = 2.0 * cosine * normal - arrival.towards;
            Vector const through = refracted(arrival.towards, normal, cosine, refraction.cosine, ratio);
            sum.reflectance += back.z > 0.0 ? weight * facet.reflectance * unshaded(back) : 0.0;
            sum.transmittance += through.z < 0.0 ? weight * facet.transmittance * unshaded(through) : 0.0;
        }
    }
    constexpr double each = 1.0 / (static_cast<double>(steps) * steps);
    return {each * sum.reflectance, each * sum.transmittance};
}

} // namespace gonio::sim
