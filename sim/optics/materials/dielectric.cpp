// dielectric.cpp: reflection or refraction with Fresnel's powers: one random number, none where reflection is total.
#include "dielectric.hpp"

#include "fresnel.hpp"

namespace gonio::sim {

Dielectric::Dielectric(double inside_index, double outside_index, double inside_absorption_per_mm)
    : ratio_from_front_(inside_index / outside_index), ratio_from_back_(outside_index / inside_index),
      inside_absorption_per_mm_(inside_absorption_per_mm) {}

Departure Dielectric::scatter(const Arrival &arrival, Photon_random &random) const {
    double const ratio = arrival.from_front ? ratio_from_front_ : ratio_from_back_;
    Refraction const refraction = refract(arrival.towards.z, ratio);
    Vector const through = refracted(arrival.towards, {0.0, 0.0, 1.0}, arrival.towards.z, refraction.cosine, ratio);
    return depart_two_way(refraction.powers, arrival, through, random);
}

double Dielectric::dsf_per_sr(const Arrival & /*arrival*/, const Vector & /*departing*/) const {
    return 0.0;
}

Albedo Dielectric::albedo(const Arrival &arrival) const {
    return unpolarised(refract(arrival.towards.z, arrival.from_front ? ratio_from_front_ : ratio_from_back_).powers);
}

} // namespace gonio::sim
