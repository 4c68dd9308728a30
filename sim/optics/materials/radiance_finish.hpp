// radiance_finish.hpp: Radiance's metal and plastic with one colour channel, as its direct calculation evaluates them
// (rt/normal.c of Radiance 5 and 6).
#pragma once

#include <memory>

#include "material.hpp"

namespace gonio::sim {

// Arguments as in Radiance: colour, specularity and roughness. Metal colours its highlight, plastic does not.
// - Roughness above 0.001: a Ward lobe (ward_lobe.hpp) of `specularity` (times colour: metal), rest diffuse, no
// Fresnel.
//   The size of the light source is not added to the roughness.
// - Else ideal; with specularity of 0.018 or more F = exp(-5.85 cos) - 0.00203 raises the specular part towards 1 at
//   grazing incidence, and the diffuse part is colour (1 - specularity) (1 - F_i) (1 - F_o). Radiance's photon map and
//   its ambient calculation leave the factor 1 - F_o out: there the diffuse part is 6 % larger and not reciprocal.
std::unique_ptr<Material> radiance_metal(double colour, double specularity, double roughness);
std::unique_ptr<Material> radiance_plastic(double colour, double specularity, double roughness);

} // namespace gonio::sim
