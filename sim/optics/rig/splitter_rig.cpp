// splitter_rig.cpp: the splitters, their baffle, and the way through them.
#include "splitter_rig.hpp"

#include <cmath>

#include "black.hpp"
#include "surrounded_scene.hpp"

namespace gonio::sim {
namespace {

const double half_root = std::sqrt(0.5);
// Of the first splitter: light from the source is reflected to -X, light from the sample to +X.
const Vector normal_1{-half_root, 0.0, half_root};
// Of the second, at a right angle.
const Vector normal_2{half_root, 0.0, half_root};
constexpr double baffle_gap_mm = 5.0; // from the splitters' edge

Vector in_splitter(const Vector &v) {
    return v - (2.0 * dot(v, normal_1)) * normal_1;
}

// Squares on edge: `along` lies in them, level.
Parallelogram square(const Vector &centre, const Vector &along, double side_mm, std::uint32_t surface) {
    Vector const up{0.0, side_mm, 0.0};
    Vector const side = side_mm * along;
    return {centre - 0.5 * (side + up), side, up, surface};
}

// The lowest edges of the splitters meet: they form a V, seen from above.
Shapes parts_of(const Splitter_rig &rig, std::uint32_t plate_surface, std::uint32_t baffle_surface,
                const Frame &lab_axes) {
    double const depth_mm = splitter_depth_mm(rig);
    std::vector<Parallelogram> parts = {square({}, normal_2, rig.side_mm, plate_surface),
                                        square({-2.0 * depth_mm, 0.0, 0.0}, normal_1, rig.side_mm, plate_surface)};
    if (rig.baffle) {
        // From the sample's plane up to the splitters: what these reflect passes above it.
        Vector const up{0.0, 2.0 * rig.side_mm, 0.0};
        Vector const depth{0.0, 0.0, rig.sample_distance_mm - depth_mm};
        Vector const corner{depth_mm + baffle_gap_mm, -rig.side_mm, -rig.sample_distance_mm};
        parts.push_back({corner, up, depth, baffle_surface});
    }
    Shapes shapes;
    for (const Parallelogram &part : parts) {
        shapes.add(Parallelogram{lab_axes.to_world(part.corner), lab_axes.to_world(part.side_u),
                                 lab_axes.to_world(part.side_v), part.surface});
    }
    return shapes;
}

} // namespace

double splitter_depth_mm(const Splitter_rig &rig) {
    return 0.5 * rig.side_mm * half_root;
}

Splitter_view seen_in_splitter(const Splitter_rig &rig, const Vector &detector, double arm_radius_mm) {
    Vector const image = in_splitter(detector);
    Vector const way = arm_radius_mm * image + Vector{0.0, 0.0, rig.sample_distance_mm};
    double const distance_mm = length(way);
    Vector const outgoing = unit(way);
    double const lengthened = distance_mm / arm_radius_mm;
    return {outgoing, distance_mm, lengthened * lengthened / dot(outgoing, image)};
}

Vector seen_from_sample(const Splitter_rig &rig, const Vector &outgoing, double arm_radius_mm) {
    // Where the way from the sample's place, sample_distance behind the centre, meets the sphere.
    double const along = rig.sample_distance_mm * outgoing.z;
    double const rest = arm_radius_mm * arm_radius_mm - rig.sample_distance_mm * rig.sample_distance_mm;
    Vector const place =
        (along + std::sqrt(along * along + rest)) * outgoing - Vector{0.0, 0.0, rig.sample_distance_mm};
    return in_splitter(unit(place));
}

void surround_with_splitters(Photon_scenario &scenario, const Splitter_rig &rig,
                             const std::function<std::unique_ptr<Material>(const Band &band)> &plate) {
    scenario.trace.polarised = true;
    scenario.sample = [sample = std::move(scenario.sample), plate](const Band &band, bool mounted) {
        Sample_model model = sample(band, mounted);
        const auto add = [&model](std::unique_ptr<Material> material) {
            const Material *made = model.materials.emplace_back(std::move(material)).get();
            model.surfaces.push_back({made, made});
        };
        add(plate(band));
        add(std::make_unique<Black>());
        return model;
    };
    scenario.surround = [rig](const Sample_model &model, std::unique_ptr<Scene> sample, const Frame &lab_axes) {
        auto const surfaces = static_cast<std::uint32_t>(model.surfaces.size()); // the last two are the rig's
        return make_surrounded_scene(parts_of(rig, surfaces - 2, surfaces - 1, lab_axes), std::move(sample),
                                     lab_axes.to_world({0.0, 0.0, -rig.sample_distance_mm}));
    };
}

} // namespace gonio::sim
