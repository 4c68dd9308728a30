// window_glass.cpp: a pane of old window glass: rough faces, bubbles, a wedge (paper [3]).
//
// Keys: material (`dielectric`; also `ggx-dielectric`: microscopic roughness), back (material of the back face, if
// another; the same medium), thickness_mm (3), size_mm (30, or [width, height]), wedge_deg (0: angle between the faces,
// thicker towards +y), front_rms_um and back_rms_um (0: height of a random relief), front_correlation_mm and
// back_correlation_mm (1), bubbles_per_cm3 (0), bubble_diameter_mm (0.2, or [least, most]), relief_seed (1). Rims are
// black. Known answers: a smooth pane transmits (1 - R)^2 a / (1 - R^2 a^2) (Hecht, Optics, ch. 4 and 9); a wedge turns
// light at normal incidence towards the thick side by asin(n sin wedge) - wedge, about (n - 1) wedge; a relief of
// correlation exp(-(d / l)^2) has slopes of sqrt(2) rms / l, so light is spread by about (n - 1) of that per face.
// Paper [3] gives for G1: thickness 2.1-4.7 mm, matt side wavy with about 1 mm, few bubbles below 0.3 mm.
#include <algorithm>
#include <cmath>

#include "kinds.hpp"
#include "pane.hpp"
#include "placing.hpp"
#include "random.hpp"

namespace gonio::sim {
namespace {

Roughness read_roughness(Toml_table &table, const std::string &face, std::uint64_t seed) {
    Roughness roughness{};
    roughness.rms_mm = 1e-3 * not_negative(table, face + "_rms_um", 0.0);
    roughness.correlation_mm = positive(table, face + "_correlation_mm", 1.0);
    if (roughness.rms_mm > 0.3 * roughness.correlation_mm) {
        table.fail(face + "_rms_um", "must be at most 0.3 of the correlation length");
    }
    roughness.seed = seed;
    return roughness;
}

// Each is held against all that are placed.
constexpr double most_bubbles = 20000.0;

struct Bubbles {
    double per_mm3;
    std::array<double, 2> diameter_mm; // least and most, uniform
    std::uint64_t seed;
};

// At random places well within the pane, none through another.
void add_bubbles(const Toml_table &table, Sample_parts &parts, const Pane &pane, const Bubbles &bubbles,
                 double relief_mm, const Material &material) {
    auto const [width, height] = pane.size_mm;
    double const slope = pane.wedge.sine / pane.wedge.cosine;
    double const thickest = pane.thickness_mm + 0.5 * height * slope;
    double const wanted = std::floor(bubbles.per_mm3 * width * height * thickest + 0.5);
    if (wanted > most_bubbles) {
        table.fail("bubbles_per_cm3", "makes more than 20000 bubbles in this pane; lower it or take a smaller pane");
    }
    auto const tries = static_cast<std::uint64_t>(wanted);
    std::uint32_t const surface = parts.cavity(material);
    std::vector<Sphere> placed;
    for (std::uint64_t number = 0; number < tries; ++number) {
        Photon_random random(bubbles.seed, number);
        double const size = random.uniform();
        double const radius = 0.5 * (bubbles.diameter_mm[0] + size * (bubbles.diameter_mm[1] - bubbles.diameter_mm[0]));
        Vector const centre{(random.uniform() - 0.5) * width, (random.uniform() - 0.5) * height,
                            -random.uniform() * thickest};
        double const room = radius + relief_mm;
        bool const inside = std::abs(centre.x) + room < 0.5 * width && std::abs(centre.y) + room < 0.5 * height &&
                            -centre.z > room &&
                            (pane.thickness_mm + centre.y * slope + centre.z) * pane.wedge.cosine > room;
        bool const alone = std::none_of(placed.begin(), placed.end(), [&](const Sphere &other) {
            return length(centre - other.centre) <= 1.01 * (radius + other.radius);
        });
        if (inside && alone) {
            placed.push_back({centre, radius, surface});
            parts.shapes().add(placed.back());
        }
    }
}

} // namespace

void add_window_glass(Toml_table &table, Sample_parts &parts) {
    const Material &front = parts.material(table, "material");
    const Material &back = table.has("back") ? parts.material(table, "back") : front;
    auto const seed = static_cast<std::uint64_t>(table.integer("relief_seed", 1));
    Pane pane{};
    pane.size_mm = table.numbers<2>("size_mm", 30.0);
    pane.thickness_mm = positive(table, "thickness_mm", 3.0);
    pane.wedge = sine_cosine_of_deg(within(table, "wedge_deg", 0.0, -30.0, 30.0));
    pane.front = read_roughness(table, "front", seed);
    pane.back = read_roughness(table, "back", seed + 1);
    double const thinning_mm = 0.5 * pane.size_mm[1] * std::abs(pane.wedge.sine / pane.wedge.cosine);
    // Five standard deviations: a relief this high is one point in millions.
    double const relief_mm = 5.0 * (pane.front.rms_mm > pane.back.rms_mm ? pane.front.rms_mm : pane.back.rms_mm);
    if (!(pane.size_mm[0] > 0.0 && pane.size_mm[1] > 0.0)) {
        table.fail("size_mm", "must be above 0");
    }
    if (pane.thickness_mm <= thinning_mm + 2.0 * relief_mm) {
        table.fail("thickness_mm", "is too small for the wedge and the relief: the faces would meet");
    }
    Bubbles const bubbles{1e-3 * not_negative(table, "bubbles_per_cm3", 0.0),
                          table.numbers<2>("bubble_diameter_mm", 0.2), seed + 2};
    if (!(bubbles.diameter_mm[0] > 0.0 && bubbles.diameter_mm[1] >= bubbles.diameter_mm[0])) {
        table.fail("bubble_diameter_mm", "must be [least, most], above 0");
    }
    if (bubbles.per_mm3 > 0.0 && bubbles.diameter_mm[0] + 2.0 * relief_mm >= pane.thickness_mm) {
        table.fail("bubble_diameter_mm", "must be below thickness_mm: no bubble fits into the pane");
    }
    add_pane(parts, pane, front, back);
    if (bubbles.per_mm3 > 0.0) {
        add_bubbles(table, parts, pane, bubbles, relief_mm, front);
    }
    parts.model().cell_width_mm = 0.5 * pane.size_mm[0];
    parts.model().cell_height_mm = 0.5 * pane.size_mm[1];
}

} // namespace gonio::sim
