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
};

} // namespace gonio::sim
