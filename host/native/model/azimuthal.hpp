// azimuthal.hpp: azimuthal equidistant coordinates about a direction.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "vec.hpp"

namespace gonio::model {

// Terms of asin(s) / (s sqrt(1 - s^2)) in powers of s^2.
inline constexpr std::size_t TERMS = 14;
inline constexpr std::array<double, TERMS> SERIES = [] {
    std::array<double, TERMS> found{1.0};
    for (std::size_t n = 1; n < TERMS; ++n) {
        found[n] = found[n - 1] * static_cast<double>(2 * n) / static_cast<double>(2 * n + 1);
    }
    return found;
}();
inline constexpr double COS_30_DEG = 0.8660254037844386;

// Angle over its sine, from the cosine z and the sine's square. The series, which is that of the half angle's sine, is
// exact to 1e-17 up to 30 degrees; wider angles are halved first: a / sin a = (a / 2) / sin(a / 2) / cos(a / 2).
inline double angle_over_sine(double z, double sine2) {
    if (z < -0.5) {
        const double sine = std::sqrt(sine2);
        return std::atan2(sine, z) / sine;
    }
    double cosines = 1.0;
    while (z < COS_30_DEG) {
        z = std::sqrt(0.5 + 0.5 * z);
        cosines *= z;
    }
    const double w = 0.5 - 0.5 * z;
    const double w2 = w * w;
    double even = SERIES[TERMS - 2];
    double odd = SERIES[TERMS - 1];
    for (std::size_t n = TERMS - 2; n > 0; n -= 2) {
        even = even * w2 + SERIES[n - 2];
        odd = odd * w2 + SERIES[n - 1];
    }
    return (even + odd * w) / cosines;
}

// What to multiply x and y along the tangents with to have the angle as their length; z along the direction itself. At
// the antipode, where all azimuths meet, x becomes one of them.
inline double stretch(double &x, double y, double z) {
    double across2 = x * x + y * y;
    if (z < 0.0 && across2 < 1e-18) {
        x = 1e-9;
        across2 = 1e-18;
    }
    return angle_over_sine(z, across2);
}

// Smaller singular value of a 2 x 2 matrix, row by row.
inline double least_stretch(const double *w) {
    const double sum = std::hypot(w[0] + w[3], w[1] - w[2]);
    const double difference = std::hypot(w[0] - w[3], w[1] + w[2]);
    return 0.5 * std::fabs(sum - difference);
}

} // namespace gonio::model
