// optics_factory.cpp: a scenario's closed forms.
#include "optics_factory.hpp"

#include <cmath>

#include "toml_table.hpp"

namespace gonio::sim {

std::unique_ptr<Optics> closed_form_optics(const Scenario &scenario) {
    if (scenario.photon_map.wanted) {
        throw Input_error(scenario.path.string() +
                          " [sample]: 'kind' needs the photon map, which this program was built " +
                          "without; build gonio-twin with Embree (-DGONIO_EMBREE=ON) or give 'components'");
    }
    double const half_angle_rad =
        std::atan(0.5 * scenario.instrument.detector_aperture_mm / scenario.instrument.arm_radius_mm);
    return std::make_unique<Closed_form>(scenario.sample, scenario.beam, half_angle_rad);
}

} // namespace gonio::sim
