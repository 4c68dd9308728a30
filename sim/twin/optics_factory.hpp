// optics_factory.hpp: who makes a scenario's optics: the closed forms here, the photon map where the program has one.
#pragma once

#include <functional>
#include <memory>

#include "optics.hpp"
#include "scenario.hpp"

namespace gonio::sim {

using Optics_factory = std::function<std::unique_ptr<Optics>(const Scenario &scenario)>;

// Throws Input_error if the scenario's sample is one for the photon map.
std::unique_ptr<Optics> closed_form_optics(const Scenario &scenario);

} // namespace gonio::sim
