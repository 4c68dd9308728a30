// test_paths.cpp: where photons go: mirrors, sides and frames, absorbing media, the receiver sphere.
#include <gtest/gtest.h>

#include "fakes.hpp"

namespace gonio::sim {
namespace {

using namespace fakes;

struct Result {
    Balance balance;
    std::vector<Receiver_hit> hits;
};

Result trace(const Scene &scene, std::span<const Surface> surfaces, const Source &source,
             const Trace_settings &settings = {}, const Frame &lab_axes = same_axes) {
    Tracer const tracer(scene, surfaces, source, lab_axes, settings);
    Tally tally;
    Watch watch;
    Balance const balance = tracer.trace({0, 1}, 1, tally, watch);
    EXPECT_EQ(excess(balance), 0);
    return {balance, tally.hits()};
}

void expect_near(const Vector &a, const Vector &b, double tolerance) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.z, b.z, tolerance);
}

// Image of a point in a mirror plane.
Vector image(const Plane &plane, const Vector &point) {
    return point - 2.0 * dot(point - plane.point, plane.normal) * plane.normal;
}

TEST(Paths, two_mirrors_turn_the_light_by_twice_their_angle) {
    // Mirrors at 45 degrees to the beam and at 25 degrees to each other.
    double const a = std::numbers::pi / 4.0;
    double const b = a + 25.0 * std::numbers::pi / 180.0;
    Plane const first{.point = {1.0, 0.0, -2.0},
                      .normal = {std::sin(a), 0.0, std::cos(a)},
                      .tangent = {0.0, 1.0, 0.0},
                      .radius_mm = 10.0};
    Plane const second{.point = {50.0, 0.0, 0.0},
                       .normal = {-std::sin(b), 0.0, -std::cos(b)},
                       .tangent = {0.0, -0.6, 0.8},
                       .radius_mm = 30.0};
    Plane tilted = second;
    tilted.tangent = unit(cross(second.normal, {0.3, 0.5, 0.1}));
    Planes const scene({first, tilted});
    Mirror const mirror;
    std::array<Surface, 2> const surfaces{both_sides(mirror), both_sides(mirror)};
    Vector const start{0.5, 1.5, 400.0};
    Vector const along = unit({0.001, 0.002, -1.0});
    Result const result = trace(scene, surfaces, Pencil(start, along));
    ASSERT_EQ(result.hits.size(), 1U);
    // The light seems to come from the image of the start in both mirrors, and has not changed its distance to it.
    Vector const seen_start = image(second, image(first, start));
    Vector const seen_along = image(second, image(first, start + along)) - seen_start;
    expect_near(result.hits[0].direction, seen_along, 1e-12);
    Vector const place = 1020.0 * result.hits[0].place;
    EXPECT_NEAR(length(result.hits[0].place), 1.0, 1e-13);
    EXPECT_NEAR(length(cross(place - seen_start, seen_along)), 0.0, 1e-9);
    EXPECT_GT(dot(place - seen_start, seen_along), 400.0);
    // By twice their angle in the plane across both (the beam is nearly in it).
    EXPECT_NEAR(dot(seen_along, along), std::cos(50.0 * std::numbers::pi / 180.0), 1e-5);
}

// Keeps what it was told; sends light where it was told.
class Probe final : public Fake {
public:
    explicit Probe(const Vector &direction) : direction_(unit(direction)) {}
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random & /*random*/) const override {
        seen = arrival;
        return {direction_, 1.0, {}};
    }
    mutable Arrival seen{};

private:
    Vector direction_;
};

TEST(Paths, material_sees_its_own_side_in_a_frame_with_the_tangent_as_x) {
    // Normal along x, tangent along z: y of the front's frame is x cross z = -y.
    Plane const wall{.point = {0.0, 0.0, 0.0}, .normal = {1.0, 0.0, 0.0}, .tangent = {0.0, 0.0, 1.0}};
    Planes const scene({wall});
    for (bool const from_front : {true, false}) {
        double const side = from_front ? 1.0 : -1.0;
        Probe const used({0.1, 0.2, 0.3});
        Probe const other({0.1, 0.2, 0.3});
        std::array<Surface, 1> const surfaces{{{from_front ? &used : &other, from_front ? &other : &used}}};
        Vector const towards = unit({side * 3.0, 2.0, 1.0});
        Result const result = trace(scene, surfaces, Pencil(100.0 * towards, -towards));
        EXPECT_EQ(used.seen.from_front, from_front);
        expect_near(used.seen.towards, unit({1.0, -side * 2.0, 3.0}), 1e-15);
        EXPECT_EQ(other.seen.towards.z, 0.0);
        ASSERT_EQ(result.hits.size(), 1U);
        expect_near(result.hits[0].direction, unit({side * 0.3, -side * 0.2, 0.1}), 1e-15);
        expect_near(result.hits[0].place, result.hits[0].direction, 1e-13);
    }
}

TEST(Paths, unpolarised_run_shows_materials_unpolarised_light) {
    Planes const scene({{.point = {0.0, 0.0, 0.0}}});
    Probe const probe({0.0, 0.0, 1.0});
    std::array<Surface, 1> const surfaces{both_sides(probe)};
    Pencil const source({{0.0, 0.0, 9.0}, {0.0, 0.0, -1.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}});
    trace(scene, surfaces, source, {.polarised = true});
    EXPECT_NEAR(std::abs(probe.seen.stokes.q), 1.0, 1e-15);
    trace(scene, surfaces, source, {.polarised = false});
    EXPECT_EQ(probe.seen.stokes.q, 0.0);
}

// A slab whose faces look outwards, its inside absorbing.
struct Slab {
    double absorption_per_mm;
    double thickness_mm;
    Planes scene{{{.point = {0.0, 0.0, 0.0}}, {.point = {0.0, 0.0, -thickness_mm}, .normal = {0.0, 0.0, -1.0}}}};
    Veil veil{};
    Mirror mirror{};

    [[nodiscard]] std::array<Surface, 2> clear() const {
        return {{{&veil, &veil, 0.0, absorption_per_mm}, {&veil, &veil, 0.0, absorption_per_mm}}};
    }
    // Its second face a mirror.
    [[nodiscard]] std::array<Surface, 2> silvered() const {
        return {{{&veil, &veil, 0.0, absorption_per_mm}, {&mirror, &mirror, 0.0, absorption_per_mm}}};
    }
};

TEST(Paths, absorbing_medium_follows_lambert_and_beer) {
    for (double const absorption : {0.0, 0.02, 0.5}) {
        for (double const tangent : {0.0, 1.5}) {
            Slab const slab{.absorption_per_mm = absorption, .thickness_mm = 3.0};
            Pencil const source({0.0, 0.0, 100.0}, {tangent, 0.0, -1.0});
            double const path_mm = 3.0 * std::sqrt(1.0 + tangent * tangent);
            Result const through = trace(slab.scene, slab.clear(), source, {.roulette_below = 0.0});
            EXPECT_NEAR(static_cast<double>(through.balance.stored), std::exp(-absorption * path_mm) * whole, 0.6);
            Result const back = trace(slab.scene, slab.silvered(), source, {.roulette_below = 0.0});
            EXPECT_NEAR(static_cast<double>(back.balance.stored), std::exp(-2.0 * absorption * path_mm) * whole, 0.6);
            EXPECT_GT(back.hits.at(0).direction.z, 0.0);
        }
    }
}

TEST(Paths, light_that_leaves_within_a_medium_is_absorbed_up_to_the_receiver) {
    Planes const scene({{.point = {0.0, 0.0, 0.0}}});
    Veil const veil;
    std::array<Surface, 1> const surfaces{{{&veil, &veil, 0.0, 0.001}}};
    Result const result = trace(scene, surfaces, Pencil({0.0, 0.0, 5.0}, {0.0, 0.0, -1.0}),
                                {.roulette_below = 0.0, .receiver_radius_mm = 800.0});
    EXPECT_NEAR(static_cast<double>(result.balance.stored), std::exp(-0.8) * whole, 0.6);
}

TEST(Paths, free_beam_crosses_the_receiver_sphere_on_its_far_side) {
    Planes const nothing({});
    // The lab's axes turned by 30 degrees about y, as for light from (30, 0).
    double const sine = 0.5;
    double const cosine = std::sqrt(0.75);
    Frame const lab{{cosine, 0.0, -sine}, {0.0, 1.0, 0.0}, {sine, 0.0, cosine}};
    for (double const distance_mm : {500.0, 1500.0}) { // the stop within and beyond the sphere
        Result const result =
            trace(nothing, {}, Pencil({30.0, 0.0, distance_mm}, {0.0, 0.0, -1.0}), {.receiver_radius_mm = 1000.0}, lab);
        ASSERT_EQ(result.hits.size(), 1U);
        expect_near(result.hits[0].direction, {-sine, 0.0, -cosine}, 1e-15);
        expect_near(result.hits[0].place, 0.03 * lab.s - std::sqrt(1.0 - 0.0009) * lab.n, 1e-13);
        EXPECT_EQ(result.hits[0].weight, whole_weight(1.0));
    }
}

TEST(Paths, light_that_passes_beside_the_receiver_ends_in_the_room) {
    Planes const nothing({});
    Pencil const beside({0.0, 0.0, 1500.0}, {2.0, 0.0, -1.0});
    Pencil const away({0.0, 0.0, 1500.0}, {0.0, 0.0, 1.0});
    for (const Pencil &source : {beside, away}) {
        Result const result = trace(nothing, {}, source);
        EXPECT_TRUE(result.hits.empty());
        EXPECT_EQ(result.balance.absorbed, result.balance.emitted);
    }
}

} // namespace
} // namespace gonio::sim
