// local_fit.hpp: gradient and curvature of a scattered function about each of many directions.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "clusters.hpp"

namespace gonio::sphere {

struct Fit {
    double value;
    Vec gradient;                  // tangent, per rad
    std::array<double, 6> hessian; // xx yy zz xy xz yz, tangent, per rad^2
    double gradient_variance;      // of one component of the gradient
};

// Described in host/gonio/geometry/local_fit.py. NaN where the points do not fix a fit.
std::vector<Fit> local_fits(std::span<const Vec> unit, std::span<const Cluster> points, double radius);

} // namespace gonio::sphere
