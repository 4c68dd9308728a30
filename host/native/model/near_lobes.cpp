// near_lobes.cpp: one product with the centre tells of most points that they are far.
#include "near_lobes.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

#include "azimuthal.hpp"

namespace gonio::model {

Near near_lobes(std::span<const Vec> unit, std::span<const Vec> frame, std::span<const double> whitening,
                double reach) {
    const std::size_t lobes = frame.size() / 3;
    if (whitening.size() != 4 * lobes) {
        throw std::invalid_argument("one frame and whitening per lobe are needed");
    }
    Near found;
    found.start.push_back(0);
    for (std::size_t l = 0; l < lobes; ++l) {
        const Vec e1 = frame[3 * l];
        const Vec e2 = frame[3 * l + 1];
        const Vec centre = frame[3 * l + 2];
        const double *const w = &whitening[4 * l];
        const double angle = reach / least_stretch(w);
        const double cosine = angle < std::numbers::pi ? std::cos(angle) : -2.0;
        for (std::size_t i = 0; i < unit.size(); ++i) {
            const double z = dot(centre, unit[i]);
            if (z >= cosine) {
                double x = dot(e1, unit[i]);
                const double y = dot(e2, unit[i]);
                const double longer = stretch(x, y, z);
                found.row.push_back(static_cast<std::int64_t>(i));
                found.place.push_back(longer * (w[0] * x + w[1] * y));
                found.place.push_back(longer * (w[2] * x + w[3] * y));
            }
        }
        found.start.push_back(static_cast<std::int64_t>(found.row.size()));
    }
    return found;
}

} // namespace gonio::model
