// mirror.cpp: no random numbers.
#include "mirror.hpp"

#include <cmath>

namespace gonio::sim {

Mirror::Mirror(double reflectance_s, double reflectance_p) {
    powers_.reflectance_s = reflectance_s;
    powers_.reflectance_p = reflectance_p;
    powers_.reflected_cross = -std::sqrt(reflectance_s * reflectance_p);
}

Departure Mirror::scatter(const Arrival &arrival, Photon_random &random) const {
    return depart_two_way(powers_, arrival, mirrored(arrival.towards), random);
}

double Mirror::dsf_per_sr(const Arrival & /*arrival*/, const Vector & /*departing*/) const {
    return 0.0;
}

Albedo Mirror::albedo(const Arrival & /*arrival*/) const {
    return unpolarised(powers_);
}

} // namespace gonio::sim
