// thin_plate.cpp: geometric series of the internal reflections (Radiance's glass evaluates the same sums for R and T).
#include "thin_plate.hpp"

#include <algorithm>

#include "elementary.hpp"
#include "fresnel.hpp"

namespace gonio::sim {
namespace {

struct Sums {
    double reflected;
    double transmitted;
};

// `passage`: what one crossing leaves. `first`: r_a r_b* of a face from outside, `enters`: t_a t_b* of in and out; with
// a = b they are powers. From inside r changes its sign, so that the product keeps its own.
Sums internal_reflections(double first, double enters, double passage) {
    double const left = 1.0 - first * first * passage * passage;
    if (!(left > 0.0)) {
        return {first, 0.0};
    }
    double const through = enters * passage / left;
    return {first + through * first * passage, through};
}

} // namespace

Two_way Plate::powers(double cosine) const {
    Refraction const face = refract(cosine, index);
    double const passage = optical_depth > 0.0 ? exponential(-optical_depth / face.cosine) : 1.0;
    Two_way const &once = face.powers;
    Sums const s = internal_reflections(once.reflectance_s, once.transmittance_s * once.transmittance_s, passage);
    Sums const p = internal_reflections(once.reflectance_p, once.transmittance_p * once.transmittance_p, passage);
    Sums const cross =
        internal_reflections(once.reflected_cross, once.transmitted_cross * once.transmitted_cross, passage);
    return {s.reflected, p.reflected, s.transmitted, p.transmitted, cross.reflected, 0.0, cross.transmitted};
}

Departure Thin_plate::scatter(const Arrival &arrival, Photon_random &random) const {
    return depart_two_way(plate_.powers(arrival.towards.z), arrival, -arrival.towards, random);
}

double Thin_plate::dsf_per_sr(const Arrival & /*arrival*/, const Vector & /*departing*/) const {
    return 0.0;
}

Albedo Thin_plate::albedo(const Arrival &arrival) const {
    return unpolarised(plate_.powers(arrival.towards.z));
}

Splitter::Splitter(double reflectance_s, double reflectance_p, double transmittance_s, double transmittance_p)
    : powers_{reflectance_s,
              reflectance_p,
              transmittance_s,
              transmittance_p,
              -std::sqrt(reflectance_s * reflectance_p),
              0.0,
              std::sqrt(transmittance_s * transmittance_p)} {}

Departure Splitter::scatter(const Arrival &arrival, Photon_random &random) const {
    return depart_two_way(powers_, arrival, -arrival.towards, random);
}

double Splitter::dsf_per_sr(const Arrival & /*arrival*/, const Vector & /*departing*/) const {
    return 0.0;
}

Albedo Splitter::albedo(const Arrival & /*arrival*/) const {
    return unpolarised(powers_);
}

Plate glass_plate(double transmissivity, double index) {
    // Opaque: so deep that nothing is left.
    return {index, -logarithm(std::max(transmissivity, 1e-300))};
}

} // namespace gonio::sim
