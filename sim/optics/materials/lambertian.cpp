// lambertian.cpp: two random numbers; the first one also chooses the side.
#include "lambertian.hpp"

#include "hemisphere.hpp"

namespace gonio::sim {

Lambertian::Lambertian(double reflectance, double transmittance)
    : reflectance_(reflectance), transmittance_(transmittance), total_(reflectance + transmittance),
      reflected_part_(total_ > 0.0 ? reflectance / total_ : 1.0) {}

Departure Lambertian::scatter(const Arrival & /*arrival*/, Photon_random &random) const {
    double const u = random.uniform();
    double const v = random.uniform();
    if (u < reflected_part_) {
        return {cosine_direction(u / reflected_part_, v), total_, {}};
    }
    Vector direction = cosine_direction((u - reflected_part_) / (1.0 - reflected_part_), v);
    direction.z = -direction.z;
    return {direction, total_, {}};
}

double Lambertian::dsf_per_sr(const Arrival & /*arrival*/, const Vector &departing) const {
    return (departing.z > 0.0 ? reflectance_ : transmittance_) * cosine_density_per_sr(departing);
}

Albedo Lambertian::albedo(const Arrival & /*arrival*/) const {
    return {reflectance_, transmittance_};
}

} // namespace gonio::sim
