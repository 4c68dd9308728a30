// retro_cubes.cpp: a retro-reflective sheet of corner cubes: three square faces each, packed without a gap.
//
// Keys: mirror (material of hollow cubes) or glass (a `dielectric`: prisms that reflect totally, behind a flat front);
// edge_mm (2: of the cubes), size_mm (80: of the round sample), land_mm (0.5: glass between front and the cubes' rims).
// Known answers: three reflections return a ray exactly, whatever its angle; at normal incidence every ray
// makes three, so hollow cubes return reflectance^3. In prisms the faces stand at 54.74 degrees to the light, beyond
// the limit of total reflection for n > 1.2248: at normal incidence all light returns, R from the front and the rest
// through it.
#include "kinds.hpp"
#include "placing.hpp"

namespace gonio::sim {
namespace {

constexpr double root_two = 1.41421356237309504880;
constexpr double root_three = 1.73205080756887729353;

// Three edges of a cube from its deepest corner, all at one angle to +z.
std::array<Vector, 3> cube_edges(double edge) {
    std::array<Vector, 3> edges{};
    double const across = edge * root_two / root_three;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        Sine_cosine const azimuth = sine_cosine_of_deg(90.0 + 120.0 * static_cast<double>(i));
        edges.at(i) = {across * azimuth.cosine, across * azimuth.sine, edge / root_three};
    }
    return edges;
}

} // namespace

void add_retro_cubes(Toml_table &table, Sample_parts &parts) {
    bool const hollow = table.has("mirror");
    if (hollow == table.has("glass")) {
        table.fail("mirror", "or 'glass' must be given, and not both");
    }
    const Material &material = parts.material(table, hollow ? "mirror" : "glass");
    double const edge = positive(table, "edge_mm", 2.0);
    double const radius = 0.5 * positive(table, "size_mm", 80.0);
    double const land = hollow ? 0.0 : positive(table, "land_mm", 0.5);
    double const pitch = root_two * edge;
    if (radius / pitch > 1000.0) {
        table.fail("size_mm", "makes more than 3 million cubes; take fewer, larger ones: their size has no effect");
    }
    std::array<Vector, 3> const edges = cube_edges(edge);
    double const corner_z = -land - 2.0 * edge / root_three;
    // Inside the glass is the side that the cubes open to; of a boundary the glass is behind.
    std::uint32_t const faces = hollow ? parts.surface(material, material) : parts.cavity(material);
    Vector const along = edges[0] - edges[1];
    Vector const aslant = edges[1] - edges[2];
    double const reach = radius + 2.0 * edge; // cubes that overlap the rim are whole
    auto const most = static_cast<int>(2.0 * reach / pitch) + 1;
    Shapes &shapes = parts.shapes();
    for (int row = -most; row <= most; ++row) {
        for (int column = -most; column <= most; ++column) {
            Vector corner = static_cast<double>(column) * along + static_cast<double>(row) * aslant;
            if (corner.x * corner.x + corner.y * corner.y > reach * reach) {
                continue;
            }
            corner.z = corner_z;
            for (std::size_t i = 0; i < edges.size(); ++i) {
                shapes.add(Parallelogram{corner, edges.at(i), edges.at((i + 1) % edges.size()), faces});
            }
        }
    }
    if (!hollow) {
        shapes.add(Disc{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 0.0, radius, parts.boundary(material)});
        std::uint32_t const rim = parts.surface(parts.black(), parts.black());
        shapes.add(Arc{{0.0, 0.0, 0.5 * corner_z},
                       {0.0, 0.0, 1.0},
                       -0.5 * corner_z,
                       radius,
                       {1.0, 0.0, 0.0},
                       2.0 * elementary::pi,
                       rim});
    }
    parts.model().cell_width_mm = pitch;
    parts.model().cell_height_mm = root_three * pitch;
}

} // namespace gonio::sim
