// place.cpp: half angles of caps.
#include "place.hpp"

#include <numbers>

#include "elementary.hpp"

namespace gonio::sim {

Half_angle::Half_angle(double rad) {
    Sine_cosine const angle = sine_cosine(std::min(rad, std::numbers::pi));
    bool const whole_sphere = rad >= std::numbers::pi;
    cosine = whole_sphere ? -2.0 : angle.cosine;
    sine = whole_sphere ? 0.0 : angle.sine;
    cosine2 = cosine * std::abs(cosine);
}

} // namespace gonio::sim
