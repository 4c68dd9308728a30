// two_way.hpp: a surface that does not scatter sends light two ways, mirrored and through: powers and states of
// polarisation of both, and the choice between them.
#pragma once

#include "material.hpp"

namespace gonio::sim {

// Powers for s and p, and what becomes of the part between them. With p = direction x s (arriving and departing alike)
// and E ~ exp(-i omega t): u = 2 Re(E_s E_p*) / I, v = 2 Im(E_s E_p*) / I, so v > 0 turns clockwise for who receives
// it, and u + i v is multiplied by r_s r_p* or t_s t_p*.
struct Two_way {
    double reflectance_s = 0.0;
    double reflectance_p = 0.0;
    double transmittance_s = 0.0;
    double transmittance_p = 0.0;
    double reflected_cross = 0.0;           // Re r_s r_p*: -R at normal incidence
    double reflected_cross_imaginary = 0.0; // Im r_s r_p*: not 0 where reflection is total
    double transmitted_cross = 0.0;         // t_s t_p*, as powers
};

inline double of_state(double s, double p, double q) {
    return 0.5 * ((1.0 + q) * s + (1.0 - q) * p);
}

inline Albedo unpolarised(const Two_way &powers) {
    return {of_state(powers.reflectance_s, powers.reflectance_p, 0.0),
            of_state(powers.transmittance_s, powers.transmittance_p, 0.0)};
}

inline Vector mirrored(const Vector &towards) {
    return {-towards.x, -towards.y, towards.z};
}

// `through`: direction of the light that is transmitted. One random number where both ways are open, else none.
inline Departure depart_two_way(const Two_way &powers, const Arrival &arrival, const Vector &through,
                                Photon_random &random) {
    Stokes const &in = arrival.stokes;
    double const reflectance = of_state(powers.reflectance_s, powers.reflectance_p, in.q);
    double const transmittance = of_state(powers.transmittance_s, powers.transmittance_p, in.q);
    double const total = reflectance + transmittance;
    if (!(total > 0.0)) {
        return {mirrored(arrival.towards), 0.0, {}};
    }
    bool const reflects = !(transmittance > 0.0) || (reflectance > 0.0 && random.uniform() * total < reflectance);
    if (reflects) {
        double const scale = 1.0 / reflectance;
        return {mirrored(arrival.towards),
                total,
                {scale * of_state(powers.reflectance_s, -powers.reflectance_p, in.q),
                 scale * (powers.reflected_cross * in.u - powers.reflected_cross_imaginary * in.v),
                 scale * (powers.reflected_cross * in.v + powers.reflected_cross_imaginary * in.u)}};
    }
    double const scale = 1.0 / transmittance;
    return {through,
            total,
            {scale * of_state(powers.transmittance_s, -powers.transmittance_p, in.q),
             scale * powers.transmitted_cross * in.u, scale * powers.transmitted_cross * in.v}};
}

} // namespace gonio::sim
