// sample.hpp: a sample to trace: its shapes, surfaces and materials. One file per kind beside it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "shapes.hpp"
#include "slat_stack.hpp"
#include "surface.hpp"

namespace gonio::sim {

struct Sample_model {
    std::vector<std::unique_ptr<Material>> materials;
    std::vector<Surface> surfaces;
    Shapes shapes;
    std::optional<Slat_stack> slats; // the same shapes again, where they are all slats: for the fast walk
    // A period of the sample along x and y, or what represents it: where light that fills whole patches falls.
    double cell_width_mm = 10.0;
    double cell_height_mm = 10.0;
};

} // namespace gonio::sim
