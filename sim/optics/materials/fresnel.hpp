// fresnel.hpp: a smooth boundary of two media: Fresnel's equations and the refracted direction.
#pragma once

#include <cmath>

#include "two_way.hpp"

namespace gonio::sim {

struct Refraction {
    Two_way powers;
    double cosine; // of the angle on the far side; 0: total reflection
};

// `cosine`: on the near side, > 0. `ratio`: index of the far medium by that of the near one. Signs and the phase of
// total reflection as in Born & Wolf, Principles of Optics, 1.5.2 (21a) and 1.5.4 (60).
inline Refraction refract(double cosine, double ratio) {
    double const square = 1.0 - (1.0 - cosine * cosine) / (ratio * ratio);
    Refraction result{};
    Two_way &powers = result.powers;
    if (!(square > 0.0)) {
        double const decay = std::sqrt(-square);
        double const real = ratio * (cosine * cosine + decay * decay);
        double const imaginary = cosine * decay * (1.0 - ratio * ratio);
        double const norm = real * real + imaginary * imaginary;
        powers.reflectance_s = 1.0;
        powers.reflectance_p = 1.0;
        powers.reflected_cross = norm > 0.0 ? (real * real - imaginary * imaginary) / norm : -1.0;
        powers.reflected_cross_imaginary = norm > 0.0 ? 2.0 * real * imaginary / norm : 0.0;
        return result;
    }
    result.cosine = std::sqrt(square);
    double const r_s = (cosine - ratio * result.cosine) / (cosine + ratio * result.cosine);
    double const r_p = (ratio * cosine - result.cosine) / (ratio * cosine + result.cosine);
    powers.reflectance_s = r_s * r_s;
    powers.reflectance_p = r_p * r_p;
    powers.transmittance_s = 1.0 - powers.reflectance_s;
    powers.transmittance_p = 1.0 - powers.reflectance_p;
    powers.reflected_cross = r_s * r_p;
    powers.transmitted_cross = std::sqrt(powers.transmittance_s * powers.transmittance_p);
    return result;
}

// Direction behind a boundary with this unit normal; `cosine` and `cosine_behind` are those of refract().
inline Vector refracted(const Vector &towards, const Vector &normal, double cosine, double cosine_behind,
                        double ratio) {
    return (cosine / ratio - cosine_behind) * normal - (1.0 / ratio) * towards;
}

} // namespace gonio::sim
