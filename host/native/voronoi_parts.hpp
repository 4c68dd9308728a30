// voronoi_parts.hpp: area and first moment between a point and an edge of its spherical Voronoi cell, cut or whole.
#pragma once

#include "vec.hpp"

namespace gonio::sphere {

constexpr double PI = 3.14159265358979323846;

struct Part {
    double area = 0.0;
    Vec moment;
};

// The great circle that bisects points a and b (unit vectors). Angles along it are counted from the middle of ab,
// towards the left of someone who goes from a to b, seen from outside.
struct Bisector {
    double chord;    // |ab|
    double tan_half; // tan(h / 2), h half the angle ab
    Vec left;
    Vec middle; // of the same length as `left`

    Bisector(const Vec &a, const Vec &b) {
        const Vec along = b - a;
        const Vec sum = a + b;
        chord = length(along);
        const double sine = 0.5 * std::fmin(chord, 2.0);
        tan_half = sine / (1.0 + std::sqrt(1.0 - sine * sine));
        left = cross(sum, along); // |sum| |along| long, as both points have unit length
        middle = chord * sum;
    }

    // tan(beta / 2) of the place on the circle towards `v`.
    [[nodiscard]] double tan_half_arc(const Vec &v) const {
        const double sine = dot(v, left);
        const double cosine = dot(v, middle);
        const double hypotenuse = std::sqrt(sine * sine + cosine * cosine);
        // Behind the sphere the sum below cancels; the other form does not.
        if (cosine < 0.0) {
            return std::fabs(sine) > 0.0 ? (hypotenuse - cosine) / sine : INFINITY;
        }
        return hypotenuse > 0.0 ? sine / (hypotenuse + cosine) : 0.0;
    }
};

// atan(x), by its series where x is small: most cells are.
inline double atan_of(double x) {
    const double s = x * x;
    if (s < 1e-4) {
        return x * (1.0 - s * (1.0 / 3.0 - s * (1.0 / 5.0 - s * (1.0 / 7.0 - s / 9.0))));
    }
    return std::atan(x);
}

// Area of the right triangle with the legs h and beta, signed as beta: tan(E/2) = tan(h/2) tan(beta/2) (spherical
// excess of a right triangle; I. Todhunter, Spherical Trigonometry, 1886, art. 103), continued past beta = 90 degrees.
inline double triangle_excess(double tan_half, double tan_half_arc) {
    return 2.0 * atan_of(tan_half * tan_half_arc);
}

// Part of a's cell no farther than `reach` from a, between a and the edge that runs on the bisector with b from the arc
// `begin` to the arc `end` (counted towards a's left as Bisector does; past the far side if end < begin). The moment
// has the sides from a in it: they cancel in the sum over a cell.
Part part_within(const Vec &a, const Vec &b, double begin, double end, double reach);

} // namespace gonio::sphere
