// test_polarised.cpp: polarised light keeps its plane on the way from surface to surface.
#include <gtest/gtest.h>

#include "fakes.hpp"
#include "polarisation.hpp"

namespace gonio::sim {
namespace {

using namespace fakes;

// Ideal, for light along its normal. Its axis is `angle_rad` from the local y (s, where there is no plane of incidence)
// towards the p that belongs to it.
class Polariser final : public Fake {
public:
    explicit Polariser(double angle_rad) : c_(std::cos(2.0 * angle_rad)), s_(std::sin(2.0 * angle_rad)) {}
    [[nodiscard]] Departure scatter(const Arrival &arrival, Photon_random & /*random*/) const override {
        double const passes = 0.5 * (1.0 + c_ * arrival.stokes.q + s_ * arrival.stokes.u);
        return {-arrival.towards, passes, {c_, s_, 0.0}};
    }

private:
    double c_;
    double s_;
};

double transmitted(const std::vector<Plane> &planes, std::span<const Surface> surfaces, const Source &source,
                   bool polarised = true) {
    Planes const scene(planes);
    Tracer const tracer(scene, surfaces, source, same_axes, {.polarised = polarised, .roulette_below = 0.0});
    Tally tally;
    Watch watch;
    Balance const balance = tracer.trace({0, 1}, 1, tally, watch);
    EXPECT_EQ(excess(balance), 0);
    return static_cast<double>(balance.stored) / whole;
}

// Malus (1809): cos^2 of the angle between the axes; each polariser lies turned in its plane and is told its axis
// relative to its own tangent.
TEST(Polarised, two_polarisers_follow_malus) {
    Pencil const source({0.0, 0.0, 100.0}, {0.0, 0.0, -1.0});
    for (double const turned : {0.0, 0.4, 2.0}) {
        for (double const angle : {0.0, 0.3, 0.8, std::numbers::pi / 2.0, 2.5}) {
            Plane const first{.point = {0.0, 0.0, 10.0}};
            Plane const second{.point = {0.0, 0.0, 0.0}, .tangent = {std::cos(turned), std::sin(turned), 0.0}};
            Polariser const one(0.2);
            // Light down -z: p of s = y is x, so angles count from y towards x, against the tangent's turn.
            Polariser const two(0.2 + turned + angle);
            std::array<Surface, 2> const surfaces{both_sides(one), both_sides(two)};
            EXPECT_NEAR(transmitted({first, second}, surfaces, source), 0.5 * std::pow(std::cos(angle), 2), 1e-6);
            // Without polarisation each takes half.
            EXPECT_NEAR(transmitted({first, second}, surfaces, source, false), 0.25, 1e-6);
        }
    }
}

// Clear surfaces at any slant between source and polariser change the plane of incidence, not the light.
TEST(Polarised, planes_of_incidence_on_the_way_do_not_matter) {
    double const angle = 0.7;
    std::vector<Plane> planes = {{.point = {0.0, 0.0, 0.0}}};
    std::vector<Surface> surfaces;
    Polariser const polariser(angle);
    Veil const veil;
    surfaces.push_back(both_sides(polariser));
    for (double const x : {0.3, -0.2, 0.0}) {
        for (double const y : {0.5, -0.1}) {
            Vector const normal = unit({x, y, x + y > 0.0 ? 1.0 : -1.0});
            planes.push_back({.point = {0.0, 0.0, 10.0 * static_cast<double>(planes.size())},
                              .normal = normal,
                              .tangent = unit(cross(normal, {0.1, 0.9, 0.2}))});
            surfaces.push_back(both_sides(veil));
        }
    }
    for (double const swings : {0.0, 0.7, 1.1, 0.7 + std::numbers::pi / 2.0}) {
        Stokes const light{0.9 * std::cos(2.0 * swings), 0.9 * std::sin(2.0 * swings), 0.1};
        Pencil const source({{0.0, 0.0, 100.0}, {0.0, 0.0, -1.0}, light, {0.0, 1.0, 0.0}});
        double const expected = 0.5 * (1.0 + 0.9 * std::cos(2.0 * (swings - angle)));
        EXPECT_NEAR(transmitted(planes, surfaces, source), expected, 1e-6);
    }
}

TEST(Polarised, turning_the_axis_follows_the_field) {
    // A field at 0.3 rad from s towards p = direction x s; the axis turns by 0.5 rad the same way.
    Vector const direction = unit({0.2, -0.4, 0.7});
    Frame const about = frame_about(direction);
    Vector const s = about.s;
    Vector const p = cross(direction, s);
    Vector const axis = std::cos(0.5) * s + std::sin(0.5) * p;
    Stokes const light{std::cos(0.6), std::sin(0.6), 0.25};
    Stokes const after = turned(light, s, axis, direction);
    EXPECT_NEAR(after.q, std::cos(-0.4), 1e-14);
    EXPECT_NEAR(after.u, std::sin(-0.4), 1e-14);
    EXPECT_EQ(after.v, 0.25);
    // The axis points either way.
    Stokes const opposite = turned(light, s, -axis, direction);
    EXPECT_NEAR(opposite.q, after.q, 1e-14);
    EXPECT_NEAR(opposite.u, after.u, 1e-14);
}

TEST(Polarised, s_is_across_the_plane_of_incidence) {
    Frame const local = frame_about(unit({0.1, 0.5, -0.3}));
    Vector const direction = unit({0.7, -0.2, 0.4});
    Vector const s = s_axis(local, direction);
    EXPECT_NEAR(length(s), 1.0, 1e-15);
    EXPECT_NEAR(dot(s, local.n), 0.0, 1e-15);
    EXPECT_NEAR(dot(s, direction), 0.0, 1e-15);
    EXPECT_EQ(s_axis(local, local.n), local.t);
}

} // namespace
} // namespace gonio::sim
