// elementary.hpp: sine, exponential and their kin from additions and multiplications alone, so that a photon's path has
// the same bits on every machine (the C library picks other code on other processors). Relative error below 1e-14.
#pragma once

namespace gonio::sim {

struct Sine_cosine {
    double sine;
    double cosine;
};

// Of a fraction of a turn, -1 to 2.
Sine_cosine sine_cosine_of_turns(double turns);
// Of an angle, magnitude below 1e4 rad.
Sine_cosine sine_cosine(double angle_rad);
double exponential(double x);
// x > 0.
double logarithm(double x);
// In (-pi, pi], the convention of std::atan2.
double arc_tangent(double y, double x);
// x in [-1, 1], clamped.
double arc_cosine(double x);

} // namespace gonio::sim
